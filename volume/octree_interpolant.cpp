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
    const CellRow row = row_of(filter, corners, size, t.y(), t.z());
    return filter == OctreeFilter::Linear ? row.linear_at(t.x()) : row.cubic_at(t.x());
}

CellRow row_of(OctreeFilter filter, const CornerData& corners, double size, double y, double z) {
    if (filter == OctreeFilter::Linear) {
        const auto at = [&](std::size_t x) {
            return (1 - z) * ((1 - y) * corners[x][0] + y * corners[x + 2][0]) +
                   z * ((1 - y) * corners[x + 4][0] + y * corners[x + 6][0]);
        };
        return {at(0), at(1), 0, 0};
    }
    const auto in_y = hermite_weights(y, size);
    const auto in_z = hermite_weights(z, size);
    // Derivative d by x, at the end `x`.
    const auto at = [&](std::size_t x, std::size_t d) {
        double sum = 0;
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t e = 0; e < 4; ++e)
                sum += in_y[k & 1][e & 1] * in_z[k >> 1][e >> 1] * corners[x + 2 * k][d + 2 * e];
        return sum;
    };
    return {at(0, 0), at(1, 0), size * at(0, 1), size * at(1, 1)};
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
