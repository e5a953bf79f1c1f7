// Exact signed distances at the samples of one tile.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/band_tiles.h"
#include "distance_transform/closest_block.h"
#include "distance_transform/tile_columns.h"

#include <tbb/enumerable_thread_specific.h>

#include <atomic>

namespace isocast {

/// How samples get their signs.
struct BandSigns {
    bool is_signed = true;
    const WindingNumber* winding = nullptr; // null leaves it to the sites' normals
};

/// Where the blocks of all tiles go: room for all, of which `count` is in use.
struct BandOutput {
    std::span<FieldBlock> blocks;
    std::span<SampleBits> negative;  // samples of each block
    std::span<ClosestBlock> closest; // of each block; unless not wanted
    std::atomic<std::size_t>& count;
};

/// The transform of a mesh, in voxels; tiles are independent of each other.
class TileTransform {
public:
    TileTransform(const Sites& sites, BandSigns signs, double voxel_size_world, bool with_closest)
        : sites_(sites), signs_(signs), voxel_size_(voxel_size_world), with_closest_(with_closest),
          memory_([with_closest] { return TileMemory(with_closest); }) {}

    /// Blocks with samples in the band, each at the next free place; their inactive samples are
    /// ± background with the sign of the active ones next to them. From several threads at once.
    ///
    /// list     numbers of all sites that hold the nearest point of a sample in the band
    /// returns  how many distances were computed
    std::int64_t run(const BandTile& tile, std::span<const std::int32_t> list,
                     const BandOutput& output);

private:
    void write(const ScannedBlock& scanned, FieldBlock& block, SampleBits& negative) const;
    void find_closest(const FieldBlock& block, const ScannedBlock& scanned,
                      ClosestBlock& closest) const;

    const Sites& sites_;
    BandSigns signs_;
    double voxel_size_;
    bool with_closest_;
    tbb::enumerable_thread_specific<TileMemory> memory_;
};

} // namespace isocast
