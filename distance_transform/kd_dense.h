// Exact signed distances at every sample of a box: the kD-tree finds a tile's triangles, which are
// then scan converted.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/kd_tree.h"
#include "distance_transform/lattice.h"
#include "distance_transform/mesh_topology.h"
#include "distance_transform/winding_number.h"
#include "volume/dense_field.h"
#include "volume/progress.h"

namespace isocast {

struct KdDenseOptions {
    IndexBox box; // of samples, in the lattice's index space
    /// Tells inside from outside; null leaves it to the normals of the closest features.
    const WindingNumber* winding = nullptr;
    double memory_bytes = std::numeric_limits<double>::infinity(); // that the samples may take
};

struct KdDenseResult {
    DenseField field; // has no half width: every sample holds its own distance
    std::int64_t distance_evaluations = 0;
};

/// Signed distance to the mesh at every sample of a box, on all cores of the current TBB arena.
///
/// topology  of lattice.mesh
/// tree      over lattice.mesh, any variant
/// accuracy  exact distances in double, rounded once to float; the same for any number of threads
/// throws    InputError for an empty box, or one that passes greatest_index; ResourceError if the
///           samples would take more memory than allowed
KdDenseResult dense_distances(const LatticeMesh& lattice, const MeshTopology& topology,
                              const KdTree& tree, const KdDenseOptions& options,
                              const Progress& progress = {});

} // namespace isocast
