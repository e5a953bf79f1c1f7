// Exact signed distances at the samples of one tile, by scan conversion of its sites.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/tile_transform.h"

#include <bit>
#include <cstring>
#include <memory>

namespace isocast {

std::int64_t TileTransform::run(const BandTile& tile, std::span<const std::int32_t> list,
                                const BandOutput& output) {
    TileColumns& columns = memory_.local().columns();
    const Vec3d origin = tile_size * tile.coordinate.cast<double>();
    const ScanKernels& kernels = sites_.kernels();
    const std::int64_t evaluations =
        kernels.scan({.sites = &sites_.arrays(),
                      .list = list.data(),
                      .count = std::ssize(list),
                      .first_sample = {origin.x(), origin.y(), origin.z()}},
                     columns);
    ScannedBlock scanned;
    for (std::uint64_t rest = tile.blocks; rest != 0; rest &= rest - 1) {
        const int b = std::countr_zero(rest);
        const Index3 at = block_in_tile(b);
        if (!kernels.finish(columns, sites_.arrays().half_width, voxel_size_, at.x(), at.y(),
                            at.z(), scanned))
            continue;
        const std::size_t place = output.count++;
        FieldBlock& block = *std::construct_at(&output.blocks[place]);
        block.coordinate = tile_blocks * tile.coordinate + at;
        write(scanned, block, output.negative[place]);
        if (with_closest_) find_closest(block, scanned, output.closest[place]);
    }
    return evaluations;
}

void TileTransform::write(const ScannedBlock& scanned, FieldBlock& block,
                          SampleBits& negative) const {
    const SampleBits active = bits_of_rows(scanned.active);
    negative = {};
    if (signs_.is_signed) {
        negative = signs_.winding
                       ? winding_signs(scanned.distance, active, voxel_size_, *signs_.winding,
                                       block_size * block.coordinate.cast<double>())
                       : bits_of_rows(scanned.negative);
        spread(active, negative);
    }
    std::uint8_t rows[64];
    set_rows(negative, rows);
    static_assert(sizeof active.words == sizeof block.active);
    std::memcpy(static_cast<void*>(&block.active), active.words.data(), sizeof block.active);
    sites_.kernels().apply_signs(scanned.distance, rows, block.values.data());
}

void TileTransform::find_closest(const FieldBlock& block, const ScannedBlock& scanned,
                                 ClosestBlock& closest) const {
    closest.offset_world.fill(Eigen::Vector3f::Zero());
    closest.feature.fill(-1);
    for_each_bit(bits_of_rows(scanned.active), [&](int i) {
        const Vec3d p = (block_size * block.coordinate + sample_of(i)).cast<double>();
        const std::int32_t site = scanned.site[i];
        closest.offset_world[i] = (voxel_size_ * (sites_.nearest_point(site, p) - p)).cast<float>();
        closest.feature[i] = sites_.feature(site);
    });
}

} // namespace isocast
