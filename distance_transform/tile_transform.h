// Exact signed distances at the samples of one tile.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/band_tiles.h"
#include "distance_transform/closest_block.h"
#include "distance_transform/winding_number.h"
#include "volume/sparse_field.h"

#include <tbb/enumerable_thread_specific.h>

#include <atomic>

namespace isocast {

/// How samples get their signs.
struct BandSigns {
    bool is_signed = true;
    const WindingNumber* winding = nullptr; // null leaves it to the sites' normals
};

/// The transform of a mesh, in voxels; tiles are independent of each other.
class TileTransform {
public:
    TileTransform(const Sites& sites, BandSigns signs, double voxel_size_world)
        : sites_(sites), signs_(signs), voxel_size_(voxel_size_world) {}

    /// Blocks with samples in the band, each at the next free place; their inactive samples are
    /// ± background with the sign of the active ones next to them. From several threads at once.
    ///
    /// list     numbers of all sites that hold the nearest point of a sample in the band
    /// blocks   room for all blocks of all tiles; `next` counts those in use
    /// closest  beside the blocks and filled too, unless empty
    /// returns  how many distances were computed
    std::int64_t run(const BandTile& tile, std::span<const std::int32_t> list,
                     std::span<FieldBlock> blocks, std::span<ClosestBlock> closest,
                     std::atomic<std::size_t>& next);

    /// Values and active samples of the block at `block.coordinate`.
    void write(const ScannedBlock& scanned, FieldBlock& block) const;

private:
    struct alignas(64) Line {
        double squares[8];
    };
    using Columns = std::vector<Line, FreshMemory<Line>>;

    void find_closest(const FieldBlock& block, const ScannedBlock& scanned,
                      ClosestBlock& closest) const;

    const Sites& sites_;
    BandSigns signs_;
    double voxel_size_;
    tbb::enumerable_thread_specific<Columns> columns_; // of a thread's tile
};

} // namespace isocast
