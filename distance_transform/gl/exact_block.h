// A block's exact distances and signs from the sites that the GPU found.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/scan_kernel.h"
#include "distance_transform/winding_number.h"
#include "volume/sparse_field.h"

#include <span>

namespace isocast {

/// A site that may hold the nearest point of a sample.
///
/// twin  shaders/distance/candidates.frag
struct Candidate {
    std::uint32_t sample; // 512 times the block's number, and the sample's within it
    std::int32_t site;
};
static_assert(sizeof(Candidate) == 8);

/// How a mesh's samples become blocks of the field.
struct ExactTransform {
    SiteArrays sites;
    const WindingNumber* winding; // null leaves signs to the sites' normals
    double half_width_voxels;
    double voxel_size_world;
};

/// Fills values and active samples of the block at `block.coordinate`, as BlockTransform::run does,
/// and to the last bit, but for exact ties.
///
/// candidates  of this block, in any order; for each sample in the band its nearest site among them
void fill_block(FieldBlock& block, std::span<const Candidate> candidates,
                const ExactTransform& transform);

} // namespace isocast
