// How an octree's cell is filled in between its corners.
// SPDX-License-Identifier: MPL-2.0
#include "volume/octree_interpolant.h"

namespace isocast {

namespace {

/// Weights of value and slope (times the edge) at both ends of [0, 1]: w[end][derivative].
std::array<std::array<double, 2>, 2> hermite_weights(double t, double size) {
    const double s = 1 - t;
    return {{{s * s * (1 + 2 * t), size * t * s * s}, {t * t * (3 - 2 * t), -size * t * t * s}}};
}

} // namespace

float interpolate(OctreeFilter filter, const CornerData& corners, double size, const Vec3d& t) {
    double sum = 0;
    if (filter == OctreeFilter::Linear) {
        for (unsigned i = 0; i < 8; ++i)
            sum += (i & 1 ? t.x() : 1 - t.x()) * (i & 2 ? t.y() : 1 - t.y()) *
                   (i & 4 ? t.z() : 1 - t.z()) * corners[i][0];
        return static_cast<float>(sum);
    }
    const auto x = hermite_weights(t.x(), size);
    const auto y = hermite_weights(t.y(), size);
    const auto z = hermite_weights(t.z(), size);
    for (unsigned i = 0; i < 8; ++i)
        for (unsigned d = 0; d < 8; ++d)
            sum += x[i & 1][d & 1] * y[i >> 1 & 1][d >> 1 & 1] * z[i >> 2][d >> 2] * corners[i][d];
    return static_cast<float>(sum);
}

void midpoint(OctreeFilter filter, std::span<const float> a, std::span<const float> b, int axis,
              double length, std::span<float> out) {
    if (filter == OctreeFilter::Linear) {
        out[0] = static_cast<float>((double{a[0]} + b[0]) / 2);
        return;
    }
    // Hermite's cubic in the middle, of each derivative and its own derivative along the edge.
    const std::size_t along = std::size_t{1} << axis;
    for (std::size_t d = 0; d < 8; ++d) {
        if (d & along) continue;
        const double slope_a = a[d | along];
        const double slope_b = b[d | along];
        out[d] = static_cast<float>((double{a[d]} + b[d]) / 2 + length * (slope_a - slope_b) / 8);
        out[d | along] =
            static_cast<float>(1.5 * (double{b[d]} - a[d]) / length - (slope_a + slope_b) / 4);
    }
}

} // namespace isocast
