// How far an octree's interpolant can go within a cell.
// SPDX-License-Identifier: MPL-2.0
#include "volume/cell_bounds.h"

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// Bézier's control values of the interpolant, n + 1 along each axis, x fastest: a polynomial lies
/// between the least and the greatest of them, and so do its derivatives with their differences.
template<int n>
std::array<double, (n + 1) * (n + 1) * (n + 1)> control_net(const CornerData& corners,
                                                            double size) {
    std::array<double, (n + 1) * (n + 1) * (n + 1)> net{};
    for (int z = 0; z <= n; ++z)
        for (int y = 0; y <= n; ++y)
            for (int x = 0; x <= n; ++x) {
                const std::array<int, 3> at = {x, y, z};
                unsigned corner = 0;
                unsigned moved = 0; // the axes along which the corner's slope counts
                double third[3] = {};
                for (unsigned a = 0; a < 3; ++a) {
                    const bool is_upper = 2 * at[a] > n;
                    corner |= static_cast<unsigned>(is_upper) << a;
                    moved |= static_cast<unsigned>(at[a] % n != 0) << a;
                    third[a] = (is_upper ? -1 : 1) * size / 3;
                }
                double value = 0;
                for (unsigned d = 0; d < (n == 1 ? 1U : 8U); ++d) {
                    if ((d & moved) != d) continue;
                    double product = corners[corner][d];
                    for (unsigned a = 0; a < 3; ++a)
                        if (d >> a & 1) product *= third[a];
                    value += product;
                }
                net[static_cast<std::size_t>(x + (n + 1) * (y + (n + 1) * z))] = value;
            }
    return net;
}

template<int n>
CellBounds bounds_of_net(const CornerData& corners, double size) {
    constexpr int across = n + 1;
    const auto net = control_net<n>(corners, size);
    const std::array<int, 3> stride = {1, across, across * across};
    Vec3d first = Vec3d::Zero();
    Mat3d second = Mat3d::Zero();
    for (int i = 0; i < static_cast<int>(net.size()); ++i) {
        const std::array<int, 3> at = {i % across, i / across % across, i / (across * across)};
        const auto net_at = [&](int j) { return net[static_cast<std::size_t>(j)]; };
        for (int a = 0; a < 3; ++a) {
            if (at[a] == n) continue;
            const double along = net_at(i + stride[a]) - net_at(i);
            first[a] = std::max(first[a], n * std::abs(along) / size);
            if (at[a] + 2 <= n)
                second(a, a) = std::max(second(a, a), n * (n - 1) / (size * size) *
                                                          std::abs(net_at(i + 2 * stride[a]) -
                                                                   net_at(i + stride[a]) - along));
            for (int b = a + 1; b < 3; ++b) {
                if (at[b] == n) continue;
                const double mixed =
                    net_at(i + stride[a] + stride[b]) - net_at(i + stride[b]) - along;
                second(a, b) = second(b, a) =
                    std::max(second(a, b), n * n / (size * size) * std::abs(mixed));
            }
        }
    }
    const auto [min, max] = std::ranges::minmax(net);
    return {min, max, first.norm(), second.norm()};
}

} // namespace

CellBounds bounds_of(OctreeFilter filter, const CornerData& corners, double size) {
    return filter == OctreeFilter::Linear ? bounds_of_net<1>(corners, size)
                                          : bounds_of_net<3>(corners, size);
}

} // namespace isocast
