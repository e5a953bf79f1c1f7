// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim_blend.h"

#include <algorithm>
#include <cmath>

namespace isocast {

Reach height_range(const SlimPatch& patch) {
    const auto& h = patch.height;
    const double r = patch.radius_world;
    const double slope = std::hypot(h[1], h[2]);
    const double mean = (h[3] + h[5]) / 2; // of the bends, and by how much two differ from it
    const double more = std::hypot(h[3] - h[5], h[4]) / 2;
    return {std::max(-r, h[0] - r * (slope + r * std::max(0.0, more - mean))),
            std::min(r, h[0] + r * (slope + r * std::max(0.0, more + mean)))};
}

double support(const SlimPatch& patch, const Vec3d& d) {
    const double r = patch.radius_world;
    const Reach heights = height_range(patch);
    const double along = d.dot(patch.normal);
    const double height = along * (along > 0 ? heights.greatest : heights.least);
    double greatest = std::min(r, r * std::sqrt(std::max(0.0, 1 - along * along)) + height);
    const int planes = patch.is_any ? 0 : patch.plane_count;
    for (int k = 0; k < planes; ++k) {
        // Of a ball that a plane cuts: its own farthest point, or one of the circle.
        const SlimPlane& plane = patch.planes[static_cast<std::size_t>(k)];
        const double towards = d.dot(plane.normal);
        if (r * towards + plane.offset_world >= 0) continue;
        const double circle =
            std::sqrt(std::max(0.0, r * r - plane.offset_world * plane.offset_world));
        greatest = std::min(greatest, -plane.offset_world * towards +
                                          circle * std::sqrt(std::max(0.0, 1 - towards * towards)));
    }
    return greatest;
}

SlimSurface placed(SlimSurface surface, const Eigen::Affine3d& to_world) {
    const double scale = std::cbrt(std::abs(to_world.linear().determinant()));
    const Mat3d turn = to_world.linear() / scale;
    for (SlimLevel& level : surface.levels) {
        level.max_error_world *= scale;
        for (SlimPatch& patch : level.patches) {
            const Mat3d before = turn * slim_axes(patch.normal);
            patch.centre_world = to_world * patch.centre_world;
            patch.radius_world *= scale;
            patch.normal = (turn * patch.normal).normalized();
            // The frame follows from the normal: turned against the one that was moved.
            const Eigen::Matrix2d q =
                (slim_axes(patch.normal).transpose() * before).topLeftCorner<2, 2>();
            auto& h = patch.height;
            const Eigen::Vector2d slope = q * Eigen::Vector2d(h[1], h[2]);
            Eigen::Matrix2d bend;
            bend << h[3], h[4] / 2, h[4] / 2, h[5];
            bend = (q * bend * q.transpose() / scale).eval();
            h = {h[0] * scale, slope.x(), slope.y(), bend(0, 0), 2 * bend(0, 1), bend(1, 1)};
            for (SlimPlane& plane : patch.planes)
                plane = {(turn * plane.normal).normalized(), plane.offset_world * scale};
        }
    }
    return surface;
}

SlimFade slim_fade(const SlimSurface& surface, std::size_t level, double pixels_per_unit) {
    const auto slope = [&](std::size_t l) { // 1 by the depth where its error is half a pixel
        return 0.5 / (pixels_per_unit * surface.levels[l].max_error_world);
    };
    return {level == 0 ? SlimFade::always : slope(level),
            level + 1 == surface.levels.size() ? 0 : slope(level + 1)};
}

std::optional<SlimFragment> slim_fragment(const SlimPatch& patch, double max_error_world,
                                          const Vec3d& origin_world, const Vec3d& direction_world,
                                          bool faces_front, double t_near) {
    const auto hits = intersect(patch, origin_world, direction_world, faces_front, t_near);
    if (hits.empty() || !(hits.front().weight > 0)) return std::nullopt;
    const double facing = -hits.front().normal.dot(direction_world);
    const double slant = std::max(std::abs(facing), least_slant * direction_world.norm());
    return SlimFragment{hits.front(), patch.errors * max_error_world / slant, facing >= 0};
}

std::optional<SlimHit> blended(std::span<const SlimFragment> fragments, const Vec3d& axis_world) {
    if (fragments.empty()) return std::nullopt;
    const auto end = [](const SlimFragment& f) { return f.hit.t + f.reach; };
    const SlimFragment& first = *std::ranges::min_element(fragments, {}, end);
    const double first_end = end(first);
    const double side = first.is_outside ? 1 : -1;
    SlimHit sum{.normal = Vec3d::Zero()};
    for (const SlimFragment& f : fragments) {
        if (f.hit.t - f.reach > first_end) continue;
        sum.t += f.hit.weight * (f.hit.t - first_end);
        const Vec3d n = side * f.hit.normal;
        const double along = axis_world.dot(n);
        sum.normal += f.hit.weight / std::max(1 + along, least_rise) * (n - along * axis_world);
        sum.weight += f.hit.weight;
    }
    const Vec3d mean = sum.normal / sum.weight;
    const double square = mean.squaredNorm();
    return SlimHit{first_end + sum.t / sum.weight,
                   side * (2 * mean + (1 - square) * axis_world) / (1 + square), sum.weight};
}

} // namespace isocast
