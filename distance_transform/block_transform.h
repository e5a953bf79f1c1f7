// Exact signed distances at the samples of one block.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/block_descent.h"
#include "distance_transform/sign.h"
#include "distance_transform/triangle_frame.h"
#include "volume/sparse_field.h"

#include <cstdint>
#include <span>

namespace isocast {

/// The transform of a mesh, in voxels; blocks are independent of each other.
class BlockTransform {
public:
    /// frames  of the mesh's triangles, positions in voxels
    BlockTransform(std::span<const TriangleFrame> frames, const SignOracle& sign,
                   double half_width_voxels, double voxel_size_world)
        : frames_(frames), sign_(sign), half_width_(half_width_voxels),
          voxel_size_(voxel_size_world) {}

    /// Fills values and active samples of the block at `block.coordinate`; inactive ones are
    /// ± background with the sign of the active ones next to them. Without active samples the
    /// values mean nothing.
    ///
    /// triangles  all that are nearest to a sample in the band
    /// returns    how many point-triangle distances were computed
    std::int64_t run(FieldBlock& block, std::span<const int> triangles,
                     DescentWorkspace& workspace) const;

private:
    std::span<const TriangleFrame> frames_;
    const SignOracle& sign_;
    double half_width_;
    double voxel_size_;
    const DescentKernels& kernels_ = descent_kernels(best_instruction_set());
};

} // namespace isocast
