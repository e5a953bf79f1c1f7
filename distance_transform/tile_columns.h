// Memory for the columns of a tile, and the places of its blocks.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/block_signs.h"
#include "distance_transform/sites.h"

#include <vector>

namespace isocast {

inline constexpr int blocks_per_tile = tile_blocks * tile_blocks * tile_blocks;

/// Of bit b of BandTile::blocks.
inline Index3 block_in_tile(int b) {
    return {b % tile_blocks, b / tile_blocks % tile_blocks, b / (tile_blocks * tile_blocks)};
}

/// TileColumns for one tile after another, on one thread.
class TileMemory {
public:
    explicit TileMemory(bool with_sites) : lines_((with_sites ? 6 : 3) * lines_per_axis) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            columns_.signed_square[axis] = lines_[axis * lines_per_axis].squares;
            columns_.site[axis] =
                with_sites ? lines_[(3 + axis) * lines_per_axis].squares : nullptr;
        }
    }
    TileMemory(TileMemory&&) = default; // the lines keep their place
    TileMemory& operator=(TileMemory&&) = default;

    TileColumns& columns() { return columns_; }

private:
    /// A line of the processor's caches.
    struct alignas(64) Line {
        double squares[8];
    };
    static constexpr std::size_t lines_per_axis =
        TileColumns::count * sizeof(double) / sizeof(Line);

    std::vector<Line, FreshMemory<Line>> lines_;
    TileColumns columns_{};
};

} // namespace isocast
