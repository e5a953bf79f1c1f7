// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isocast {

Mat3d slim_axes(const Vec3d& normal) {
    const double sign = std::copysign(1.0, normal.z());
    const double a = -1 / (sign + normal.z());
    const double b = normal.x() * normal.y() * a;
    Mat3d axes;
    axes.col(0) = Vec3d(1 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x());
    axes.col(1) = Vec3d(b, sign + normal.y() * normal.y() * a, -normal.y());
    axes.col(2) = normal;
    return axes;
}

SlimQuadric slim_quadric(const SlimPatch& patch) {
    const Mat3d axes = slim_axes(patch.normal);
    const auto& h = patch.height;
    Mat3d bend = Mat3d::Zero();
    bend.topLeftCorner<2, 2>() << -h[3], -h[4] / 2, -h[4] / 2, -h[5];
    return {axes * bend * axes.transpose(), axes * Vec3d(-h[1] / 2, -h[2] / 2, 0.5), -h[0]};
}

bool is_kept(const SlimPatch& patch, const Vec3d& from_centre_world, double spare_world) {
    const auto keeps = [&](int i) {
        return patch.planes[static_cast<std::size_t>(i)].side_of(from_centre_world) >= -spare_world;
    };
    if (patch.plane_count == 0) return true;
    if (patch.plane_count == 1) return keeps(0);
    return patch.is_any ? keeps(0) || keeps(1) : keeps(0) && keeps(1);
}

double slim_weight(double share) {
    if (share >= 1) return 0;
    return share < 0.5 ? std::exp(-4 * share * share)
                       : 4 / std::numbers::e * (1 - share) * (1 - share);
}

std::size_t SlimSurface::patch_count() const {
    std::size_t count = 0;
    for (const SlimLevel& level : levels) count += level.patches.size();
    return count;
}

namespace {

void check(const SlimLevel& level, std::size_t number) {
    if (!(level.max_error_world > 0) || !std::isfinite(level.max_error_world))
        throw InputError(fmt::format("SLIM level {}: its error {} is not positive", number,
                                     level.max_error_world));
    for (std::size_t i = 0; i < level.patches.size(); ++i) {
        const SlimPatch& patch = level.patches[i];
        const auto fail = [&](const char* what) {
            throw InputError(fmt::format("SLIM level {}, patch {}: {}", number, i, what));
        };
        // 1e-9: of the roundings of a normal that was written and read.
        const auto is_unit = [](const Vec3d& n) { return std::abs(n.squaredNorm() - 1) < 1e-9; };
        if (!patch.centre_world.allFinite()) fail("its centre is not finite");
        if (!(patch.radius_world > 0) || !std::isfinite(patch.radius_world))
            fail("its radius is not positive");
        if (!(patch.errors >= 1) || !std::isfinite(patch.errors))
            fail("it may be off by less than the error");
        if (!is_unit(patch.normal)) fail("its normal is not of unit length");
        if (!std::ranges::all_of(patch.height, [](double c) { return std::isfinite(c); }))
            fail("its function is not finite");
        if (patch.plane_count < 0 || patch.plane_count > 2) fail("it has more than two planes");
        for (int k = 0; k < patch.plane_count; ++k) {
            const SlimPlane& plane = patch.planes[static_cast<std::size_t>(k)];
            if (!is_unit(plane.normal) || !std::isfinite(plane.offset_world))
                fail("a plane of it is none");
        }
    }
}

} // namespace

void check(const SlimSurface& surface) {
    if (surface.levels.empty()) throw InputError("SLIM: it has no level");
    for (std::size_t i = 0; i < surface.levels.size(); ++i) {
        check(surface.levels[i], i);
        if (i > 0 && !(surface.levels[i].max_error_world > surface.levels[i - 1].max_error_world))
            throw InputError(
                fmt::format("SLIM level {}: its error is not above that of the finer level", i));
    }
}

std::vector<SlimHit> intersect(const SlimPatch& patch, const Vec3d& origin_world,
                               const Vec3d& direction_world, bool faces_front, double t_near) {
    const SlimQuadric f = slim_quadric(patch);
    const Vec3d& v = direction_world;
    const double t0 = v.dot(patch.centre_world - origin_world) / v.squaredNorm();
    const Vec3d y = origin_world + t0 * v - patch.centre_world;
    const double alpha = v.dot(f.a * v);
    const double beta = v.dot(f.a * y + f.b);
    const double gamma = y.dot(f.a * y + 2 * f.b) + f.c;
    const double discriminant = beta * beta - alpha * gamma;
    if (!(discriminant >= 0)) return {};
    const double root = std::sqrt(discriminant);
    const double q = -(beta + std::copysign(root, beta));
    std::vector<SlimHit> hits;
    for (const double s : {q / alpha, gamma / q}) {
        const Vec3d p = y + s * v;
        const double share = p.norm() / patch.radius_world;
        const double t = t0 + s;
        const Vec3d gradient = f.a * p + f.b;
        if (!(share < 1) || !(t >= t_near) || !is_kept(patch, p) || gradient.isZero(0)) continue;
        if (faces_front && !(gradient.dot(v) < 0)) continue;
        if (!hits.empty() && hits.front().t == t) continue;
        hits.push_back({t, gradient.stableNormalized(), slim_weight(share)});
    }
    std::ranges::sort(hits, {}, &SlimHit::t);
    return hits;
}

bool is_turned_away(const SlimPatch& patch, const Vec3d& eye_world, bool is_perspective,
                    const Vec3d& view_direction) {
    const SlimQuadric f = slim_quadric(patch);
    if (!is_perspective) {
        // Half the gradient, A p + b, along v, least over the sphere.
        return view_direction.dot(f.b) > patch.radius_world * (f.a * view_direction).norm();
    }
    const Vec3d e = eye_world - patch.centre_world;
    const Vec3d b = f.a * e + f.b; // eq. 9
    const double c = e.dot(f.a * e + 2 * f.b) + f.c;
    return c < e.dot(b) - patch.radius_world * b.norm(); // eq. 18 with c'_sph = -e
}

} // namespace isocast
