// Triangles that are drawn one by one, beside quadrics.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace isocast {

/// Triangles over shared vertices, counter-clockwise seen from outside; both sides are drawn. Those
/// without area are not.
struct TriangleMesh {
    std::vector<Vec3d> vertices_world;
    std::vector<std::array<int, 3>> triangles;
    /// Of each corner, three a triangle: what the surface is shaded by. Empty: the faces' own.
    std::vector<Eigen::Vector3f> normals_world = {};
    Vec3d colour = Vec3d(0.72, 0.6, 0.42); // linear
};

/// throws  InputError that names the mesh and the vertex or triangle, by their indices, and what is
///         wrong: a vertex that is not finite, a triangle of one that there is not, a number of
///         normals that is not that of corners
void check(std::span<const TriangleMesh> meshes);

/// One of them.
struct Triangle {
    std::array<Vec3d, 3> corners_world;
};
inline Triangle triangle_of(const TriangleMesh& mesh, std::size_t i) {
    const auto corner = [&](std::size_t k) {
        return mesh.vertices_world[static_cast<std::size_t>(mesh.triangles[i][k])];
    };
    return {{corner(0), corner(1), corner(2)}};
}

/// Across the triangle, twice its area long; 0 exactly where its edges are parallel in double.
inline Vec3d area_normal(const Triangle& triangle) {
    const auto& [a, b, c] = triangle.corners_world;
    return (b - a).cross(c - a);
}

/// The corner that is farthest in the direction d.
inline const Vec3d& farthest_point(const Triangle& triangle, const Vec3d& d) {
    return *std::ranges::max_element(triangle.corners_world, {},
                                     [&](const Vec3d& corner) { return d.dot(corner); });
}

/// As `normals_world` has them, of flat faces too.
std::array<Eigen::Vector3f, 3> corner_normals_of(const TriangleMesh& mesh, std::size_t i);

} // namespace isocast
