// Exact signed distances at the samples of a band, tile by tile.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/band_tiles.h"
#include "distance_transform/closest_block.h"
#include "distance_transform/tile_columns.h"

#include <tbb/enumerable_thread_specific.h>

#include <atomic>
#include <bit>

namespace isocast {

/// How samples get their signs.
struct BandSigns {
    bool is_signed = true;
    const WindingNumber* winding = nullptr; // null leaves it to the sites' normals
};

/// Blocks with samples in a band, in any order.
struct BandSamples {
    FieldBlocks blocks = {};
    std::vector<SampleBits> negative = {};  // samples of each block, if known
    std::vector<ClosestBlock> closest = {}; // of each block, if wanted
};

/// The transform of a mesh, in voxels; tiles are independent of each other, and threads may run it
/// side by side.
class TileTransform {
public:
    /// most_blocks  that all tiles may have
    TileTransform(const Sites& sites, BandSigns signs, double voxel_size_world,
                  std::size_t most_blocks, bool with_closest = false);

    /// Adds the blocks of a tile with samples in the band; their inactive samples are ± background
    /// with the sign of the active ones next to them.
    ///
    /// list     numbers of all sites that hold the nearest point of a sample in the band
    /// returns  how many distances were computed
    std::int64_t run(const BandTile& tile, std::span<const std::int32_t> list);

    /// The same from distances of another maker, with
    /// finish(number of the block's bit, its place in the tile, ScannedBlock&) as
    /// ScanKernels::finish.
    template<class Finish>
    void add_blocks(const BandTile& tile, const Finish& finish) {
        ScannedBlock scanned;
        for (std::uint64_t rest = tile.blocks; rest != 0; rest &= rest - 1) {
            const int b = std::countr_zero(rest);
            if (finish(b, block_in_tile(b), scanned))
                add(tile_blocks * tile.coordinate + block_in_tile(b), scanned);
        }
    }

    /// All blocks.
    BandSamples take();

private:
    /// Places for blocks that one thread fills: when memory is new, threads wait for each other
    /// where they write side by side.
    struct Run {
        std::size_t next = 0;
        std::size_t end = 0;
    };
    static constexpr std::size_t blocks_per_run = 64;

    std::size_t next_place();
    void add(const Index3& coordinate, const ScannedBlock& scanned);
    void find_closest(const FieldBlock& block, const ScannedBlock& scanned,
                      ClosestBlock& closest) const;

    const Sites& sites_;
    BandSigns signs_;
    double voxel_size_;
    BandSamples samples_;
    std::atomic<std::size_t> place_count_ = 0; // of all runs
    tbb::enumerable_thread_specific<Run> runs_;
    tbb::enumerable_thread_specific<TileMemory> memory_;
};

} // namespace isocast
