// Exact signed distances at the samples of one block.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/closest_block.h"
#include "distance_transform/scan_kernel.h"
#include "distance_transform/winding_number.h"
#include "volume/sparse_field.h"

#include <span>

namespace isocast {

/// How the samples of a block get their signs.
struct BlockSigns {
    bool is_signed = true;
    const WindingNumber* winding = nullptr; // null leaves it to the sites' normals
};

/// The transform of a mesh, in voxels; blocks are independent of each other.
class BlockTransform {
public:
    BlockTransform(const SiteArrays& sites, BlockSigns signs, double half_width_voxels,
                   double voxel_size_world)
        : sites_(sites), signs_(signs), half_width_(half_width_voxels),
          voxel_size_(voxel_size_world) {}

    /// Fills values and active samples of the block at `block.coordinate`; inactive ones are
    /// ± background with the sign of the active ones next to them. Without active samples the
    /// values mean nothing.
    ///
    /// closest  filled too, unless null
    /// list     numbers of all sites that hold the nearest point of a sample in the band
    /// returns  how many distances were computed
    std::int64_t run(FieldBlock& block, std::span<const std::int32_t> list,
                     ClosestBlock* closest = nullptr) const;

private:
    void find_closest(const Vec3d& origin, const ScanOutput& scanned, ClosestBlock& closest) const;

    SiteArrays sites_;
    BlockSigns signs_;
    double half_width_;
    double voxel_size_;
    ScanKernel scan_ = scan_kernel(best_instruction_set());
};

} // namespace isocast
