// Which tiles the band can reach, and which sites can be nearest to a sample of each.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/sites.h"
#include "volume/progress.h"

#include <cstdint>
#include <span>

namespace isocast {

/// A tile of 32^3 samples and the sites that its samples may need.
struct BandTile {
    Index3 coordinate;    // relative to the anchor: from sample 32 * coordinate on
    std::uint64_t blocks; // bit x + 4 y + 16 z: a site reaches that block of 8^3 samples
    std::size_t first;    // of its sites in BandTiles::sites
    std::size_t count;
};

struct BandTiles {
    std::vector<BandTile> tiles; // by z, y, x
    std::vector<std::int32_t> sites;
    std::size_t block_count = 0; // of all tiles

    std::span<const std::int32_t> sites_of(const BandTile& tile) const {
        return std::span(sites).subspan(tile.first, tile.count);
    }
};

/// Every tile and block with a sample within the half width of the mesh (and a few others), each
/// tile with every site that is nearest to such a sample, in ascending order.
///
/// memory_bytes  what the blocks of the field and the lists of sites may take
/// throws        ResourceError if they would take more
BandTiles find_band_tiles(const Sites& sites, double memory_bytes, const Progress& progress);

/// A number of bytes that the blocks of the field surely take, from areas and lengths alone.
///
/// mesh  positions in voxels
double least_field_bytes(const Mesh& mesh, double half_width_voxels);

/// throws  ResourceError that says so
[[noreturn]] void refuse_memory(double bytes, double memory_bytes);

} // namespace isocast
