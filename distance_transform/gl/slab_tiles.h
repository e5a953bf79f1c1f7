// The parts of the lattice that the GPU draws: slabs of slices, cut into square tiles.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/band_blocks.h"
#include "volume/sparse_field.h"

namespace isocast {

/// Edge of a tile along x and y, in samples. Small beside the slices of a large field, so that only
/// what the surface reaches is drawn; large beside a site, so that few sites are in several tiles.
inline constexpr int tile_size = 64;
inline constexpr int tile_blocks = tile_size / block_size;

/// The samples tile_size * x … along x and y, slab_height * z … along z.
struct SlabTile {
    Index3 first_sample;
    std::uint32_t begin; // of its blocks in SlabTiles::order
    std::uint32_t end;
};

/// Tiles that hold a block of the band, slab by slab.
struct SlabTiles {
    std::vector<SlabTile> tiles;
    std::vector<std::uint32_t> order; // numbers of the band's blocks, tile by tile

    std::span<const std::uint32_t> blocks(const SlabTile& tile) const {
        return std::span(order).subspan(tile.begin, tile.end - tile.begin);
    }
};

/// slab_height  slices of a slab, a multiple of the block size
SlabTiles slab_tiles(const BandBlocks& band, int slab_height);

/// Sites of all blocks of a tile, each once, in ascending order.
std::vector<std::int32_t> sites_of_tile(const BandBlocks& band,
                                        std::span<const std::uint32_t> blocks);

} // namespace isocast
