// A triangle with what its closest points need, for many points in one neighbourhood.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/point_triangle.h"

namespace isocast {

struct PreparedTriangle {
    std::array<Vec3d, 3> corners;
    std::array<Vec3d, 3> edges;  // edge k from corner k to the next
    Vec3d normal;                // unit
    std::array<Vec3d, 3> inward; // unit, in the triangle's plane and across edge k
    double height_above_edge1;   // of corner 0

    /// Slivers, whose normals say little, get no number for normal and inward.
    explicit PreparedTriangle(const std::array<Vec3d, 3>& corners);
};

/// closest_point(p, triangle.corners), several times faster where `guess` is the closest feature:
/// whether p lies in its Voronoi region takes two or three products. Where it does not, the product
/// that says so names the feature to try next; after a few the general function is called.
/// accuracy  distances within rounding of the general function's; the feature can differ where two
///           are at the same distance
/// source    the walk over features is that of Lin & Canny 1991
ClosestPoint closest_point(const Vec3d& p, const PreparedTriangle& triangle, Feature guess);

} // namespace isocast
