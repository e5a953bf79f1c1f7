// Exact signed distances at the samples of one block.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/scan_kernel.h"
#include "distance_transform/winding_number.h"
#include "volume/sparse_field.h"

#include <span>

namespace isocast {

/// The transform of a mesh, in voxels; blocks are independent of each other.
class BlockTransform {
public:
    /// winding  tells inside from outside; null leaves it to the sites' normals
    BlockTransform(const SiteArrays& sites, const WindingNumber* winding, double half_width_voxels,
                   double voxel_size_world)
        : sites_(sites), winding_(winding), half_width_(half_width_voxels),
          voxel_size_(voxel_size_world) {}

    /// Fills values and active samples of the block at `block.coordinate`; inactive ones are
    /// ± background with the sign of the active ones next to them. Without active samples the
    /// values mean nothing.
    ///
    /// list     numbers of all sites that hold the nearest point of a sample in the band
    /// returns  how many distances were computed
    std::int64_t run(FieldBlock& block, std::span<const std::int32_t> list) const;

private:
    SiteArrays sites_;
    const WindingNumber* winding_;
    double half_width_;
    double voxel_size_;
    ScanKernel scan_ = scan_kernel(best_instruction_set());
};

} // namespace isocast
