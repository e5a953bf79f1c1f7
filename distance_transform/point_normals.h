// Normals of points that came without.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/point_tree.h"

#include <vector>

namespace isocast {

/// Unit normals of the planes through each point's nearest ones, turned so that neighbours agree
/// along a tree of least total turning, and so that each part of the cloud that hangs together has
/// the normal of its farthest point from its centroid outward.
///
/// tree    over `points`
/// throws  InputError if all points lie on a line
/// source  Hoppe et al. 1992
std::vector<Vec3d> estimated_normals(std::span<const Vec3d> points, const PointTree& tree,
                                     int neighbours);

} // namespace isocast
