// Exact signed distances at every sample of a box, from the kD-tree: blocks share candidates.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/kd_tree.h"
#include "distance_transform/lattice.h"
#include "distance_transform/sign.h"
#include "volume/dense_field.h"
#include "volume/progress.h"

namespace isocast {

struct KdDenseOptions {
    IndexBox box; // of samples, in the lattice's index space
    /// Whether the winding number is constant off the surface, as for closed oriented meshes, so
    /// that neighbours which the surface cannot part need but one evaluation. Pseudonormals do not
    /// look at it.
    bool is_closed_and_oriented = true;
    double memory_bytes = std::numeric_limits<double>::infinity(); // that the samples may take
};

struct KdDenseResult {
    DenseField field; // has no half width: every sample holds its own distance
    std::int64_t distance_evaluations = 0;
};

/// Signed distance to the mesh at every sample of a box, on all cores of the current TBB arena.
///
/// tree      over lattice.mesh, any variant
/// accuracy  exact point-triangle distances in double, rounded once to float; the same for any
///           number of threads
/// throws    InputError for an empty box, or one that passes greatest_index; ResourceError if the
///           samples would take more memory than allowed
KdDenseResult dense_distances(const LatticeMesh& lattice, const KdTree& tree,
                              const SignOracle& sign, const KdDenseOptions& options,
                              const Progress& progress = {});

} // namespace isocast
