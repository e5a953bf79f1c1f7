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

} // namespace isocast
