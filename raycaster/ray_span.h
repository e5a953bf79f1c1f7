// Where a ray is in a box.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <algorithm>
#include <limits>

namespace isocast {

/// Parameters t >= 0 of origin + t * direction.
struct RaySpan {
    double begin = 0;
    double end = std::numeric_limits<double>::infinity();

    bool is_empty() const { return !(begin <= end); }
};

/// In the box lo ... hi, its faces included: by slabs, one axis after the other.
inline RaySpan span_in_box(const Vec3d& origin, const Vec3d& direction, const Vec3d& lo,
                           const Vec3d& hi) {
    RaySpan span;
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0) {
            if (origin[axis] < lo[axis] || origin[axis] > hi[axis]) return {1, 0};
            continue;
        }
        const double t0 = (lo[axis] - origin[axis]) / direction[axis];
        const double t1 = (hi[axis] - origin[axis]) / direction[axis];
        span.begin = std::max(span.begin, std::min(t0, t1));
        span.end = std::min(span.end, std::max(t0, t1));
    }
    return span;
}

} // namespace isocast
