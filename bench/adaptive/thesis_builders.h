// The thesis's ways to build an octree, beside which build_adaptive is tested and measured.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/exact_distance.h"
#include "volume/hashed_octree.h"

namespace isocast {

struct ThesisTree {
    HashedOctree tree;           // linear, its hanging nodes constrained
    std::size_t evaluations = 0; // of the distance; no position is asked for twice
};

/// Divides the cells of which not all corners are on one side, down to the finest. A cell whose
/// corners all are, one of them within half a diagonal of the surface, is divided if one of the
/// nodes that it would have `look_ahead` levels below it is on the other side. The three levels
/// that build_adaptive divides are divided here too.
/// source  Sigg 2006 (thesis), 3.4
ThesisTree built_top_down(const ExactDistance& distance, int depth, int look_ahead);

/// From all nodes of the finest level: cells with nodes on one side only are coalesced.
/// source  Sigg 2006 (thesis), 3.4
ThesisTree built_bottom_up(const ExactDistance& distance, int depth);

} // namespace isocast
