// Quadratic functions in tetrahedra, whose zero sets are pieces of quadrics.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace isocast {

/// Of corners k and l, which share the edge `edge_of(k, l)`.
inline constexpr std::array<std::array<int, 2>, 6> tetrahedron_edges{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// The function sum_i c_i l_i^2 + 2 sum_ij c_ij l_i l_j of barycentric coordinates l, negative
/// inside: its Bernstein-Bézier form.
struct Tetrahedron {
    std::array<Vec3d, 4> corners_world;
    Eigen::Matrix4d coefficients; // symmetric

    /// Columns: the gradients of the barycentric coordinates.
    Eigen::Matrix<double, 3, 4> barycentric_gradients() const;
};

/// Tetrahedra over shared vertices. Functions of neighbours agree on the face between them where
/// its six coefficients are the same floats: then rays find no crack there.
struct TetrahedralMesh {
    std::vector<Vec3d> vertices_world;
    std::vector<std::array<int, 4>> tetrahedra; // indices rise: faces look the same from both sides
    /// Of each: of the corners, then of tetrahedron_edges.
    std::vector<std::array<float, 10>> coefficients;
    /// Whether a way from afar meets the surface from outside first: the function is positive
    /// wherever the tetrahedra, and those without a surface, end.
    bool is_closed = false;
    Vec3d colour = Vec3d(0.72, 0.6, 0.42); // linear
};

Tetrahedron tetrahedron_of(const TetrahedralMesh& mesh, std::size_t i);

/// Appends a tetrahedron in the order that the mesh needs, if its function may be 0 in it.
void append(TetrahedralMesh& mesh, const std::array<int, 4>& corners,
            const std::array<float, 10>& coefficients);

/// throws  InputError that names the mesh and the vertex or tetrahedron, by their indices, and what
///         is wrong: a number that is not finite, a vertex that there is not, corners that do not
///         rise, as many functions as tetrahedra
void check(std::span<const TetrahedralMesh> meshes);

/// Whether all its corners lie in a plane, exactly in double.
bool is_without_volume(const Tetrahedron& tetrahedron);

/// The corner that is farthest in the direction d.
inline const Vec3d& farthest_point(const Tetrahedron& tetrahedron, const Vec3d& d) {
    return *std::ranges::max_element(tetrahedron.corners_world, {},
                                     [&](const Vec3d& corner) { return d.dot(corner); });
}

/// Where a ray first meets the surface in a tetrahedron.
struct TetrahedronHit {
    double t = 0;
    Vec3d normal; // unit
};
/// In double, by the quadric's equation along the ray and the four planes; shaders know neither.
///
/// returns  the hit with the least t >= t_near, if there is one
std::optional<TetrahedronHit> intersect(const Tetrahedron& tetrahedron, const Vec3d& origin_world,
                                        const Vec3d& direction_world, double t_near = 0);

} // namespace isocast
