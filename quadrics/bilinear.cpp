// SPDX-License-Identifier: MPL-2.0
#include "quadrics/bilinear.h"

#include "quadrics/indexed_mesh.h"

#include <cmath>

namespace isocast {

Vec3d Patch::point(double u, double v) const {
    const auto& [c0, c1, c2, c3] = corners_world;
    return (1 - v) * ((1 - u) * c0 + u * c1) + v * ((1 - u) * c3 + u * c2);
}

Vec3d Patch::along_u(double v) const {
    const auto& [c0, c1, c2, c3] = corners_world;
    return (1 - v) * (c1 - c0) + v * (c2 - c3);
}

Vec3d Patch::along_v(double u) const {
    const auto& [c0, c1, c2, c3] = corners_world;
    return (1 - u) * (c3 - c0) + u * (c2 - c1);
}

void check(std::span<const PatchMesh> meshes) {
    for (std::size_t m = 0; m < meshes.size(); ++m)
        check_elements(fmt::format("patches {}", m), "quad ", meshes[m].vertices_world,
                       meshes[m].quads);
}

bool is_without_area(const Patch& patch) {
    const auto& [c0, c1, c2, c3] = patch.corners_world;
    return (c1 - c0).cross(c2 - c0).isZero(0) && (c2 - c0).cross(c3 - c0).isZero(0) &&
           (c1 - c0).cross(c3 - c0).isZero(0) && (c2 - c1).cross(c3 - c1).isZero(0);
}

std::optional<PatchHit> intersect(const Patch& patch, const Vec3d& origin_world,
                                  const Vec3d& direction_world, double t_near) {
    // Two directions across the ray, by the axis that it is farthest from.
    Eigen::Index axis = 0;
    direction_world.cwiseAbs().minCoeff(&axis);
    const Vec3d x = direction_world.cross(Vec3d::Unit(axis)).normalized();
    const Vec3d y = direction_world.cross(x).normalized();
    const auto across = [&](const Vec3d& p) { return Eigen::Vector2d(x.dot(p), y.dot(p)); };
    const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
        return a.x() * b.y() - a.y() * b.x();
    };
    const auto& [c0, c1, c2, c3] = patch.corners_world;
    // a + u b + v c + uv d = 0
    const Eigen::Vector2d a = across(c0 - origin_world);
    const Eigen::Vector2d b = across(c1 - c0);
    const Eigen::Vector2d c = across(c3 - c0);
    const Eigen::Vector2d d = across((c2 - c3) - (c1 - c0));
    const double v2 = cross(c, d); // v2 v^2 + v1 v + v0 = 0
    const double v1 = cross(a, d) + cross(c, b);
    const double v0 = cross(a, b);
    const double discriminant = v1 * v1 - 4 * v2 * v0;
    if (!(discriminant >= 0)) return std::nullopt;
    const double q = -0.5 * (v1 + std::copysign(std::sqrt(discriminant), v1));
    std::optional<PatchHit> first;
    for (const double v : {q / v2, v0 / q}) {
        if (!(v >= 0 && v <= 1)) continue;
        const Eigen::Vector2d along = b + v * d;
        const double u = -along.dot(a + v * c) / along.squaredNorm();
        if (!(u >= 0 && u <= 1)) continue;
        const double t =
            direction_world.dot(patch.point(u, v) - origin_world) / direction_world.squaredNorm();
        if (!(t >= t_near) || (first && first->t <= t)) continue;
        const Vec3d normal = patch.along_u(v).cross(patch.along_v(u));
        first = {t, u, v,
                 normal.isZero(0) ? Vec3d(-direction_world.normalized())
                                  : Vec3d(normal.stableNormalized())};
    }
    return first;
}

} // namespace isocast
