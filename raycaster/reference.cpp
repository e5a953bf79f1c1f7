// SPDX-License-Identifier: MPL-2.0
#include "raycaster/reference.h"

#include "filtering/reconstruct.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isocast {

std::optional<double> reference_hit(const FieldSource& field, double iso, const Ray& ray,
                                    double step_voxels) {
    const GridSpace& space = field.space();
    const Vec3d origin = space.to_index(ray.origin_world);
    const Vec3d direction = space.world_from_index.linear().inverse() * ray.direction_world;

    // Clip to the extent: slabs.
    double t_begin = 0;
    double t_end = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double lo = field.extent().lo[axis];
        const double hi = field.extent().hi[axis] - 1;
        if (direction[axis] == 0) {
            if (origin[axis] < lo || origin[axis] > hi) return std::nullopt;
            continue;
        }
        const double t0 = (lo - origin[axis]) / direction[axis];
        const double t1 = (hi - origin[axis]) / direction[axis];
        t_begin = std::max(t_begin, std::min(t0, t1));
        t_end = std::min(t_end, std::max(t0, t1));
    }
    if (!(t_begin <= t_end)) return std::nullopt;

    const auto value = [&](double t) {
        return tricubic_value(field, origin + t * direction) - iso;
    };
    const double step = step_voxels / direction.norm();
    // Signed distances have slope one at most, and so has their smoothing spline: from a value f
    // no root is nearer than |f|.
    const bool is_distance = field.half_width_world().has_value();
    double t0 = t_begin;
    double f0 = value(t0);
    while (t0 < t_end) {
        const double safe = is_distance ? std::abs(f0) / ray.direction_world.norm() : 0;
        double t1 = std::min(t0 + std::max(step, 0.99 * safe), t_end);
        double f1 = value(t1);
        if ((f1 < 0) != (f0 < 0)) {
            while (t1 - t0 > 1e-12 * (t_end - t_begin)) {
                const double t = 0.5 * (t0 + t1);
                if (t == t0 || t == t1) break;
                ((value(t) < 0) == (f0 < 0) ? t0 : t1) = t;
            }
            return 0.5 * (t0 + t1);
        }
        t0 = t1;
        f0 = f1;
    }
    return std::nullopt;
}

} // namespace isocast
