// Distance from a point to a triangle, and which feature of it is closest.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <array>

namespace isocast {

/// Edge01 joins corners 0 and 1, and so on.
enum class Feature { Face, Edge01, Edge12, Edge20, Vertex0, Vertex1, Vertex2 };
/// Of the edge that starts at a corner, and of the corner.
inline constexpr std::array edge_features = {Feature::Edge01, Feature::Edge12, Feature::Edge20};
inline constexpr std::array vertex_features = {Feature::Vertex0, Feature::Vertex1,
                                               Feature::Vertex2};

struct ClosestPoint {
    Vec3d p;
    double squared_distance;
    Feature feature;
};

/// The closest point of triangle `corners` to `p`; degenerate triangles count as their edges.
ClosestPoint closest_point(const Vec3d& p, const std::array<Vec3d, 3>& corners);

} // namespace isocast
