// Points over the gaps of a cloud, where it was not sampled.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/point_cloud.h"
#include "distance_transform/winding_number.h"

#include <span>

namespace isocast {

/// Points with unit normals on the surface w = 1/2 of the winding number, as far as it spans gaps:
/// where no point is within `cell` and two of its spacings. About one for each square of `cell`.
/// The surface follows the cloud's own rim, and is flat over a hole with a flat rim.
///
/// points, spacing  of the cloud [any unit]; see CheckedPoints
/// cell             edge of the cubes in which the surface is looked for, at least two median
///                  spacings
/// winding          of the cloud, positive inside
/// source           Barill et al. 2018, for the surface
PointCloud points_over_gaps(std::span<const Vec3d> points, std::span<const double> spacing,
                            double cell, const WindingNumber& winding);

} // namespace isocast
