// SPDX-License-Identifier: MPL-2.0
#include "quadrics/cut.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <cmath>

namespace isocast {

void check(const Cut& cut) {
    if (cut.planes.size() > max_cut_planes)
        throw InputError(
            fmt::format("{} cut planes: {} at most", cut.planes.size(), max_cut_planes));
    for (std::size_t i = 0; i < cut.planes.size(); ++i) {
        const CutPlane& plane = cut.planes[i];
        if (!plane.normal.allFinite() || plane.normal.isZero(0))
            throw InputError(fmt::format("cut plane {}: its normal has no direction", i));
        if (!std::isfinite(plane.offset_world))
            throw InputError(fmt::format("cut plane {}: its offset is not finite", i));
    }
    if (cut.near_world && !(*cut.near_world > 0 && std::isfinite(*cut.near_world)))
        throw InputError("a cut near the viewer must lie in front of it");
}

double depth_inside(const Quadric& quadric, const Vec3d& p_world) {
    const Vec3d q =
        quadric.local_from_world * (p_world - quadric.anchor_world - quadric.centre_from_anchor);
    switch (quadric.kind) {
    case QuadricKind::Ball:
        return q.squaredNorm() - 1;
    case QuadricKind::Cone: {
        const double r = quadric.radius_middle + quadric.radius_slope * q.z();
        return std::max(q.z() * q.z() - 1, q.head<2>().squaredNorm() - r * r);
    }
    case QuadricKind::General:
        break;
    }
    const double size = q.cwiseAbs().maxCoeff();
    return std::max(size * size - 1, q.dot(quadric.a * q) + 2 * quadric.b.dot(q) + quadric.c);
}

double depth_inside(const Superquadric& superquadric, const Vec3d& p_world) {
    const auto seen = seen_from<double>(superquadric, p_world);
    return superquadric_norm(Vec3d(seen.local_from_world * seen.centre), seen.exponents).value - 1;
}

} // namespace isocast
