// A triangle mesh in double precision.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <array>
#include <vector>

namespace isocast {

/// Triangles over shared vertices, counter-clockwise seen from outside.
struct Mesh {
    std::vector<Vec3d> vertices_world;
    std::vector<std::array<int, 3>> triangles;
};

struct WorldBox {
    Vec3d min;
    Vec3d max;
    Vec3d size() const { return max - min; }
};

/// Box of the vertices that triangles use. Needs at least one triangle.
WorldBox bounding_box(const Mesh& mesh);

/// Unit normal of a triangle, 0 if it has no area; from the two shorter edges, whose cross product
/// rounds least.
Vec3d face_normal(const Mesh& mesh, int triangle);

/// The angle between two vectors, as exact when small: the arc cosine of their product is not.
double angle_between(const Vec3d& a, const Vec3d& b);

} // namespace isocast
