// Exact signed distances at the samples of a band, by scan conversion of each tile's sites.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/tile_transform.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace isocast {

TileTransform::TileTransform(const Sites& sites, BandSigns signs, double voxel_size_world,
                             std::size_t most_blocks, bool with_closest)
    : sites_(sites), signs_(signs), voxel_size_(voxel_size_world),
      memory_([with_closest] { return TileMemory(with_closest); }) {
    const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    const std::size_t places = most_blocks + threads * blocks_per_run;
    samples_.blocks.resize(places);
    samples_.negative.resize(places);
    samples_.closest.resize(with_closest ? places : 0);
}

std::int64_t TileTransform::run(const BandTile& tile, std::span<const std::int32_t> list) {
    TileColumns& columns = memory_.local().columns();
    const Vec3d origin = tile_size * tile.coordinate.cast<double>();
    const std::int64_t evaluations =
        sites_.kernels().scan({.sites = &sites_.arrays(),
                               .list = list.data(),
                               .count = std::ssize(list),
                               .first_sample = {origin.x(), origin.y(), origin.z()}},
                              columns);
    add_blocks(tile, [&](int, const Index3& at, ScannedBlock& scanned) {
        return sites_.kernels().finish(columns, sites_.arrays().half_width, voxel_size_, at.x(),
                                       at.y(), at.z(), scanned);
    });
    return evaluations;
}

BandSamples TileTransform::take() {
    // The last blocks move to the places that the threads have left.
    std::vector<std::size_t> left;
    for (const Run& run : runs_)
        for (std::size_t place = run.next; place < run.end; ++place) left.push_back(place);
    std::ranges::sort(left);
    const std::size_t block_count = place_count_ - left.size();
    std::size_t last = place_count_;
    for (const std::size_t place : left) {
        if (place >= block_count) break;
        do --last;
        while (std::ranges::binary_search(left, last));
        samples_.blocks[place] = samples_.blocks[last];
        samples_.negative[place] = samples_.negative[last];
        if (!samples_.closest.empty()) samples_.closest[place] = samples_.closest[last];
    }
    samples_.blocks.resize(block_count);
    samples_.negative.resize(block_count);
    if (!samples_.closest.empty()) samples_.closest.resize(block_count);
    return std::move(samples_);
}

std::size_t TileTransform::next_place() {
    Run& run = runs_.local();
    if (run.next == run.end) {
        run.next = place_count_.fetch_add(blocks_per_run);
        run.end = run.next + blocks_per_run;
    }
    return run.next++;
}

void TileTransform::add(const Index3& coordinate, const ScannedBlock& scanned) {
    const std::size_t place = next_place();
    FieldBlock& block = *std::construct_at(&samples_.blocks[place]);
    block.coordinate = coordinate;
    const SampleBits active = bits_of_rows(scanned.active);
    SampleBits& negative = samples_.negative[place];
    if (signs_.is_signed) {
        negative = signs_.winding
                       ? winding_signs(scanned.distance, active, voxel_size_, *signs_.winding,
                                       block_size * coordinate.cast<double>())
                       : bits_of_rows(scanned.negative);
        spread(active, negative);
    }
    std::uint8_t rows[64];
    set_rows(negative, rows);
    static_assert(sizeof active.words == sizeof block.active);
    std::memcpy(static_cast<void*>(&block.active), active.words.data(), sizeof block.active);
    sites_.kernels().apply_signs(scanned.distance, rows, block.values.data());
    if (!samples_.closest.empty()) find_closest(block, scanned, samples_.closest[place]);
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
