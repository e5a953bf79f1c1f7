// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/gl/slab_tiles.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <numeric>

namespace isocast {

namespace {

int floor_divide(int a, int b) {
    return (a - (a % b + b) % b) / b;
}

} // namespace

SlabTiles slab_tiles(const BandBlocks& band, int slab_height) {
    const Index3 tile_extent(tile_blocks, tile_blocks, slab_height / block_size);
    std::vector<Index3> tile_of_block(band.blocks.size());
    for (std::size_t i = 0; i < band.blocks.size(); ++i)
        for (int k = 0; k < 3; ++k)
            tile_of_block[i][k] = floor_divide(band.blocks[i].coordinate[k], tile_extent[k]);
    SlabTiles result;
    result.order.resize(band.blocks.size());
    std::iota(result.order.begin(), result.order.end(), 0);
    tbb::parallel_sort(result.order.begin(), result.order.end(),
                       [&](std::uint32_t a, std::uint32_t b) {
                           if (tile_of_block[a] != tile_of_block[b])
                               return zyx_less(tile_of_block[a], tile_of_block[b]);
                           return a < b;
                       });
    for (std::uint32_t i = 0; i < result.order.size(); ++i) {
        const Index3& tile = tile_of_block[result.order[i]];
        if (i == 0 || tile != tile_of_block[result.order[i - 1]])
            result.tiles.push_back({.first_sample = block_size * tile.cwiseProduct(tile_extent),
                                    .begin = i,
                                    .end = i});
        result.tiles.back().end = i + 1;
    }
    return result;
}

std::vector<std::int32_t> sites_of_tile(const BandBlocks& band,
                                        std::span<const std::uint32_t> blocks) {
    std::vector<std::int32_t> sites;
    for (const std::uint32_t b : blocks) {
        const auto of_block = band.sites(band.blocks[b]);
        sites.insert(sites.end(), of_block.begin(), of_block.end());
    }
    std::ranges::sort(sites);
    sites.erase(std::unique(sites.begin(), sites.end()), sites.end());
    return sites;
}

} // namespace isocast
