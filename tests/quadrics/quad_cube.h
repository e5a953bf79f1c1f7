// The faces of a cube in cells, welded: a closed mesh of quads of any shape.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/bilinear.h"

#include <array>
#include <map>
#include <utility>

namespace isocast::test {

/// n x n quads on each face of the cube [-1, 1]^3, turning to the left as seen from outside.
///
/// moved  (p): where a point of the cube goes; each vertex is asked for once
template<class Moved>
PatchMesh quad_cube(int n, const Moved& moved) {
    PatchMesh mesh;
    std::map<std::array<int, 3>, int> numbers;
    const auto vertex = [&](const std::array<int, 3>& p) {
        const auto [at, is_new] = numbers.try_emplace(p, int(mesh.vertices_world.size()));
        if (is_new) mesh.vertices_world.push_back(moved(Vec3d(Vec3d(p[0], p[1], p[2]) / n)));
        return at->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1})
            for (int i = -n; i < n; i += 2)
                for (int j = -n; j < n; j += 2) {
                    const auto at = [&](int a, int b) {
                        std::array<int, 3> p{};
                        p[axis] = side * n;
                        p[(axis + 1) % 3] = a;
                        p[(axis + 2) % 3] = b;
                        return vertex(p);
                    };
                    std::array quad{at(i, j), at(i + 2, j), at(i + 2, j + 2), at(i, j + 2)};
                    if (side < 0) std::swap(quad[1], quad[3]);
                    mesh.quads.push_back(quad);
                }
    return mesh;
}

} // namespace isocast::test
