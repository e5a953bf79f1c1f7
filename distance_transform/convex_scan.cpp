// Scan conversion of convex polyhedra: each row is clipped by each half-space.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convex_scan.h"

#include <algorithm>
#include <cmath>

namespace isocast {

RowInterval clip_row(std::span<const HalfSpace> polyhedron, const Index3& first, int count) {
    double lo = 0;
    double hi = count - 1;
    for (const HalfSpace& h : polyhedron) {
        const double room = h.offset + scan_slack - h.normal.dot(first.cast<double>());
        const double slope = h.normal.x();
        if (slope > 0)
            hi = std::min(hi, room / slope);
        else if (slope < 0)
            lo = std::max(lo, room / slope);
        else if (room < 0)
            return {0, 0};
    }
    if (!(lo <= hi)) return {0, 0}; // before the conversions: beyond the row they may be infinite
    return {static_cast<int>(std::ceil(lo)), static_cast<int>(std::floor(hi)) + 1};
}

std::vector<Index3> blocks_meeting(std::span<const HalfSpace> polyhedron, const WorldBox& box) {
    const Index3 first = (box.min / block_size).array().floor().cast<int>();
    const Index3 last = (box.max / block_size).array().floor().cast<int>();
    const auto is_outside = [&](const Index3& block, const HalfSpace& h) {
        const Vec3d least_corner = block_size * block.cast<double>();
        double least = h.normal.dot(least_corner); // of normal · p over the block's samples
        for (int k = 0; k < 3; ++k) least += std::min(0.0, (block_size - 1) * h.normal[k]);
        return least > h.offset + scan_slack;
    };
    std::vector<Index3> blocks;
    for (int z = first.z(); z <= last.z(); ++z) {
        for (int y = first.y(); y <= last.y(); ++y) {
            for (int x = first.x(); x <= last.x(); ++x) {
                const Index3 block(x, y, z);
                if (std::ranges::none_of(polyhedron,
                                         [&](const auto& h) { return is_outside(block, h); }))
                    blocks.push_back(block);
            }
        }
    }
    return blocks;
}

} // namespace isocast
