// Exact signed distances at the samples of one block.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"
#include "distance_transform/pseudonormals.h"
#include "distance_transform/winding_number.h"
#include "volume/sparse_field.h"

#include <cstdint>
#include <span>
#include <variant>

namespace isocast {

/// What tells inside from outside: the normal of the closest feature, or the winding number.
using SignOracle = std::variant<Pseudonormals, WindingNumber>;

/// The transform of a mesh, in voxels; blocks are independent of each other.
class BlockTransform {
public:
    /// mesh  vertices in voxels
    BlockTransform(const Mesh& mesh, const SignOracle& sign, double half_width_voxels,
                   double voxel_size_world)
        : mesh_(mesh), sign_(sign), half_width_(half_width_voxels), voxel_size_(voxel_size_world) {}

    /// Fills values and active samples of the block at `block.coordinate`; inactive ones are
    /// ± background with the sign of the active ones next to them. Without active samples the
    /// values mean nothing.
    ///
    /// triangles  all that are closest to a sample in the band; ties go to the first
    /// returns    how many point-triangle distances were computed
    std::int64_t run(FieldBlock& block, std::span<const int> triangles) const;

private:
    const Mesh& mesh_;
    const SignOracle& sign_;
    double half_width_;
    double voxel_size_;
};

/// Gives every inactive sample ± background, by the sign of the active ones from which it is
/// reached through inactive ones. Right since distance is 1-Lipschitz and the half width at least
/// one voxel: neighbours with different signs are both within one voxel of the surface.
void spread_signs(FieldBlock& block, float background_world);

} // namespace isocast
