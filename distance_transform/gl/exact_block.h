// A block's exact distances and sides from the sites that the GPU found.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/gl/seen_tile.h"

namespace isocast {

/// A site that may hold the nearest point of a sample.
///
/// twin  shaders/distance/candidates.frag
struct Candidate {
    std::uint32_t sample; // 512 times the block's number, and the sample's within it
    std::uint32_t site;   // in SeenTile::sites
};
static_assert(sizeof(Candidate) == 8);

/// Does what ScanKernels::finish does, to the last bit but for exact ties; finds no numbers of
/// sites.
///
/// at          the block's place in the tile's 4^3
/// candidates  of this block, in any order; for each sample in the band its nearest site among them
bool finish_block(const SeenTile& tile, const Index3& at, std::span<const Candidate> candidates,
                  double half_width, double scale, ScannedBlock& block);

} // namespace isocast
