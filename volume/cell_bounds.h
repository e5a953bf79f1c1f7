// How far an octree's interpolant can go within a cell.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/octree_interpolant.h"

namespace isocast {

struct CellBounds {
    double min; // of values
    double max;
    double slope; // no gradient is longer
    double bend;  // no second derivative, along any direction, is greater
};

/// Of the whole cell; min and max of a linear one are reached.
CellBounds bounds_of(OctreeFilter filter, const CornerData& corners, double size);

} // namespace isocast
