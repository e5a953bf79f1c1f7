// Which blocks the band can reach, and which sites can be nearest to a sample of each.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/sites.h"
#include "volume/progress.h"

#include <cstdint>
#include <span>

namespace isocast {

/// A block of 8^3 samples and the sites that its samples may need.
struct BandBlock {
    Index3 coordinate;  // relative to the anchor: samples 8 * coordinate … 8 * coordinate + 7
    std::uint32_t list; // which of BandBlocks::lists holds the sites, and where
    std::uint32_t first;
    std::uint32_t count;
    std::uint32_t place; // of the block among all, by z, y, x
};

struct BandBlocks {
    /// Near ones stand together, so that they share sites in the processor's caches.
    std::vector<BandBlock> blocks;
    std::vector<std::vector<std::int32_t>> lists;

    std::span<const std::int32_t> sites(const BandBlock& block) const {
        return std::span(lists[block.list]).subspan(block.first, block.count);
    }
};

/// Every block with a sample within the half width of the mesh (and a few others), each with every
/// site that is nearest to such a sample.
///
/// Sites are sorted into tiles of 8^3 blocks, and within each tile into blocks.
///
/// memory_bytes  what the blocks of the field may take
/// throws        ResourceError if they would take more
BandBlocks find_band_blocks(const Sites& sites, double memory_bytes, const Progress& progress);

/// A number of bytes that the blocks of the field surely take, from areas and lengths alone.
///
/// mesh  positions in voxels
double least_field_bytes(const Mesh& mesh, double half_width_voxels);

/// throws  ResourceError that says so
[[noreturn]] void refuse_memory(double bytes, double memory_bytes);

} // namespace isocast
