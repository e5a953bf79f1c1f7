// Bilinear patches: quadrilaterals that need not be flat.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace isocast {

/// The points (1-u)(1-v) c0 + u(1-v) c1 + uv c2 + (1-u)v c3 with u and v from 0 to 1: corners in
/// the order around it, counter-clockwise seen from outside.
struct Patch {
    std::array<Vec3d, 4> corners_world;

    Vec3d point(double u, double v) const;
    Vec3d along_u(double v) const; // derivative by u
    Vec3d along_v(double u) const;
};

/// Patches over shared vertices; both sides are drawn. Those without area are not. A triangle is a
/// patch with its first corner twice.
struct PatchMesh {
    std::vector<Vec3d> vertices_world;
    std::vector<std::array<int, 4>> quads;
    Vec3d colour = Vec3d(0.72, 0.6, 0.42); // linear
};

inline Patch patch_of(const PatchMesh& mesh, std::size_t i) {
    const auto corner = [&](std::size_t k) {
        return mesh.vertices_world[static_cast<std::size_t>(mesh.quads[i][k])];
    };
    return {{corner(0), corner(1), corner(2), corner(3)}};
}

/// throws  InputError that names the mesh and the vertex or quad, by their indices, and what is
///         wrong: a vertex that is not finite, a quad of one that there is not
void check(std::span<const PatchMesh> meshes);

/// Whether all its corners lie on one line, exactly in double.
bool is_without_area(const Patch& patch);

/// The corner that is farthest in the direction d.
inline const Vec3d& farthest_point(const Patch& patch, const Vec3d& d) {
    return *std::ranges::max_element(patch.corners_world, {},
                                     [&](const Vec3d& corner) { return d.dot(corner); });
}

/// Where a ray meets a patch first.
struct PatchHit {
    double t = 0;
    double u = 0;
    double v = 0;
    Vec3d normal; // unit
};
/// In double, by the quadratic equation in v of the ray's two coordinates across it; shaders solve
/// that in u by volumes.
///
/// returns  the hit with the least t >= t_near, if there is one
/// source   Ramsey, Potter, Hansen 2004
std::optional<PatchHit> intersect(const Patch& patch, const Vec3d& origin_world,
                                  const Vec3d& direction_world, double t_near = 0);

} // namespace isocast
