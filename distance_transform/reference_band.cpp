// Blocks from distances, and the comparison of two bands.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/reference_band.h"

#include "distance_transform/block_signs.h"
#include "distance_transform/convex_scan.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isocast {

FieldBlock BlockDistances::to_block(const Index3& coordinate, double half_width_voxels,
                                    double voxel_size_world) const {
    FieldBlock block{.coordinate = coordinate};
    for (int i = 0; i < samples_per_block; ++i) {
        const double distance = std::abs(signed_voxels[i]);
        // The slack keeps samples exactly on the band's border in it.
        if (!(distance <= half_width_voxels + scan_slack)) continue;
        block.active[i] = true;
        block.values[i] = static_cast<float>(std::copysign(
            voxel_size_world * std::min(distance, half_width_voxels), signed_voxels[i]));
    }
    const SampleBits active = active_bits(block);
    SampleBits negative = negative_bits(block);
    spread(active, negative);
    apply_signs(block, active, negative, static_cast<float>(half_width_voxels * voxel_size_world));
    return block;
}

BandErrors band_errors(std::span<const FieldBlock> exact, std::span<const FieldBlock> other,
                       double voxel_size_world) {
    BandErrors errors;
    // What the exact transform promises, so that only the other band's errors count.
    const double tolerance = 1e-5 * voxel_size_world;
    double worst = 0;
    const FieldBlock nothing;
    auto b = other.begin();
    const auto count_extra_before = [&](const FieldBlock* block) {
        for (; b != other.end() && (!block || zyx_less(b->coordinate, block->coordinate)); ++b)
            errors.extra += static_cast<std::int64_t>(b->active.count());
    };
    for (const FieldBlock& a : exact) {
        count_extra_before(&a);
        const bool is_there = b != other.end() && b->coordinate == a.coordinate;
        const FieldBlock& found = is_there ? *b++ : nothing;
        errors.samples += static_cast<std::int64_t>(a.active.count());
        errors.missing += static_cast<std::int64_t>((a.active & ~found.active).count());
        errors.extra += static_cast<std::int64_t>((found.active & ~a.active).count());
        for (int i = 0; i < samples_per_block; ++i) {
            if (!a.active[i] || !found.active[i]) continue;
            const double beyond = std::abs(double{found.values[i]}) - std::abs(double{a.values[i]});
            worst = std::max(worst, std::abs(beyond));
            errors.too_far += beyond > tolerance ? 1 : 0;
            const bool is_on_surface = std::abs(a.values[i]) <= 1e-9 * voxel_size_world;
            errors.wrong_signs +=
                !is_on_surface && (found.values[i] < 0) != (a.values[i] < 0) ? 1 : 0;
        }
    }
    count_extra_before(nullptr);
    errors.worst_voxels = worst / voxel_size_world;
    return errors;
}

} // namespace isocast
