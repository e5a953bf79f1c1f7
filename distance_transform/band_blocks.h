// Which blocks the band can reach, and which triangles can be closest to a sample of each.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/lattice.h"
#include "distance_transform/triangle_frame.h"
#include "volume/progress.h"

#include <cstdint>
#include <span>

namespace isocast {

/// A block of 8^3 samples and the triangles that its samples may need.
struct BandBlock {
    Index3 coordinate;  // relative to the anchor: samples 8 * coordinate … 8 * coordinate + 7
    std::uint32_t list; // which of BandBlocks::lists holds the triangles, and where
    std::uint32_t count;
    std::size_t first;
};

struct BandBlocks {
    /// Sorted by z, y, x.
    std::vector<BandBlock> blocks;
    std::vector<std::vector<int>> lists;
    std::int64_t distance_evaluations = 0;

    std::span<const int> triangles(const BandBlock& block) const {
        return std::span(lists[block.list]).subspan(block.first, block.count);
    }
};

/// Culling margin [voxels]: far above the rounding of distances between coordinates below 2^28
/// voxels (1e-7), far below what culling gains.
inline constexpr double culling_slack = 1e-6;

/// Every block with a sample within `half_width_voxels` of the mesh (and a few others), each with
/// every triangle that is closest to such a sample.
///
/// An octree of blocks is descended. A node keeps the triangles whose box and plane come within the
/// half width of it; where nodes are small against the band, distances cull much more
/// (block_descent.inl).
///
/// frames        of the lattice mesh's triangles
/// memory_bytes  what the blocks of the field may take
/// throws        ResourceError if they would take more; where the mesh's area alone says so, at
///               once
BandBlocks find_band_blocks(const LatticeMesh& lattice, std::span<const TriangleFrame> frames,
                            double half_width_voxels, double memory_bytes,
                            const Progress& progress);

} // namespace isocast
