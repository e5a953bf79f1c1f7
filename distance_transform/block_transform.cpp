// Exact signed distances at the samples of one block, by scan conversion of its sites.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/block_transform.h"

#include "distance_transform/block_signs.h"

namespace isocast {

std::int64_t BlockTransform::run(FieldBlock& block, std::span<const std::int32_t> list) const {
    const Vec3d origin = block_size * block.coordinate.cast<double>();
    const ScanInput input{.sites = &sites_,
                          .list = list.data(),
                          .count = static_cast<std::int32_t>(list.size()),
                          .first_sample = {origin.x(), origin.y(), origin.z()},
                          .half_width = half_width_,
                          .scale = voxel_size_,
                          .with_sites = false};
    ScanOutput scanned;
    const std::int64_t evaluations = scan_(input, scanned);
    std::ranges::copy(scanned.distance, block.values.begin());
    const SampleBits active = bits_of_rows(scanned.active);
    SampleBits negative = winding_
                              ? winding_signs(block.values, active, voxel_size_, *winding_, origin)
                              : bits_of_rows(scanned.negative);
    spread(active, negative);
    apply_signs(block, active, negative, static_cast<float>(voxel_size_ * half_width_));
    return evaluations;
}

} // namespace isocast
