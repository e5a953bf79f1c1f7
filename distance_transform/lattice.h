// The lattice of samples, and the mesh measured in its voxels.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

namespace isocast {

/// Greatest |index| that a sample may have; 32-bit arithmetic on indices then cannot overflow.
inline constexpr int greatest_index = 1 << 28;

/// A mesh in voxels relative to a lattice point near its middle: from here on no coordinate is
/// larger than the mesh, wherever in the world it lies.
struct LatticeMesh {
    GridSpace space;
    /// Index of the lattice point in `space`; a multiple of the block size.
    Index3 anchor;
    /// Vertices in voxels from the anchor.
    Mesh mesh;
    WorldBox box; // of `mesh`, in voxels too
};

/// Samples at integer multiples of the voxel size; where an index of the band would pass
/// greatest_index, the transform is shifted by whole voxels.
/// throws  InputError if doubles at the mesh's place in the world cannot tell voxels apart,
///         ResourceError if the mesh spans more than 2 greatest_index voxels
LatticeMesh on_lattice(const Mesh& mesh, double voxel_size_world, double half_width_voxels);

} // namespace isocast
