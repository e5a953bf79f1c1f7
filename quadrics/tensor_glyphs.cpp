// SPDX-License-Identifier: MPL-2.0
#include "quadrics/tensor_glyphs.h"

#include <algorithm>
#include <cmath>

namespace isocast {

double typical_curvature(std::span<const CurvedPoint> points) {
    std::vector<double> sizes;
    for (const CurvedPoint& p : points)
        for (const double k : {p.k1, p.k2})
            if (k != 0) sizes.push_back(std::abs(k));
    if (sizes.empty()) return 1;
    const auto quartile = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 4);
    std::nth_element(sizes.begin(), quartile, sizes.end());
    return *quartile;
}

std::vector<Ellipsoid> curvature_ellipsoids(std::span<const CurvedPoint> points,
                                            const CurvatureGlyphLook& look) {
    const double full = look.curvature_of_size.value_or(typical_curvature(points));
    std::vector<Ellipsoid> ellipsoids;
    ellipsoids.reserve(points.size());
    for (const CurvedPoint& point : points) {
        const Vec3d& n = point.normal;
        Vec3d d1 = point.direction1 - n * n.dot(point.direction1);
        // 1e-6: a unit direction along the normal leaves only roundings, which are no direction.
        d1 = d1.norm() > 1e-6 ? d1.normalized() : n.unitOrthogonal();
        const Vec3d d2 = n.cross(d1);

        const auto semi_axis = [&](double k) {
            const double share = std::sqrt(full / std::abs(k)); // infinite where it is flat
            return look.size_world * std::clamp(share, look.least_share, 1.0);
        };
        const double a1 = semi_axis(point.k1), a2 = semi_axis(point.k2);
        const auto rise = [](double k, double a) { return std::clamp(-k * a * a / 2, 0.0, a); };
        const double lift = std::max(rise(point.k1, a1), rise(point.k2, a2));

        Ellipsoid ellipsoid{.centre_world = point.position_world + n * lift};
        ellipsoid.axes_world << d1 * a1, d2 * a2, n * (look.thickness_share * std::min(a1, a2));

        const double k1 = std::abs(point.k1), k2 = std::abs(point.k2);
        const double greater = std::max(k1, k2);
        const double difference = greater > 0 ? 1 - std::min(k1, k2) / greater : 0;
        const Vec3d along = (k1 >= k2 ? d1 : d2).cwiseAbs();
        const Vec3d grey = Vec3d::Constant(0.5); // between no light and all
        // Both infinite: no direction.
        ellipsoid.colour = std::isnan(difference)
                               ? grey
                               : Vec3d(grey + difference * (along / along.maxCoeff() - grey));
        ellipsoids.push_back(ellipsoid);
    }
    return ellipsoids;
}

} // namespace isocast
