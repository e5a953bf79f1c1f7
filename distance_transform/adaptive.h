// Adaptive distance fields: an octree that is divided where its interpolant misses the distance.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/exact_distance.h"
#include "volume/hashed_octree.h"
#include "volume/progress.h"

#include <limits>
#include <optional>

namespace isocast {

struct AdaptiveOptions {
    int depth = 8;
    OctreeFilter filter = OctreeFilter::Linear;
    /// What the interpolant may err by [finest cells]. Empty divides all cells that hold a part of
    /// the surface down to the finest, and no others.
    std::optional<double> max_error_cells = 0.5;
    /// It may err by more the farther a point lies beyond this from the surface [finest cells]: by
    /// a quarter of how far.
    double accurate_within_cells = 0;
    /// May be taken while it grows.
    double memory_bytes = std::numeric_limits<double>::infinity();
};

/// How far features are found: above the finest level no cell hides a body, or a gap, that reaches
/// deeper into it, from each of its faces, than this share of the error that is allowed. So a body
/// that holds a ball of a greater radius is found wherever it lies.
inline constexpr double hidden_share = 0.125;

/// The octree over [0, 2^depth]^3 of a signed distance.
///
/// A cell is divided
///   - if a part of the surface lies in it, its corners are all on one side, and that part does not
///     keep within hidden_share * max_error of one of the cell's faces;
///   - if its interpolant is not within max_error of zero on all of that part;
///   - if the interpolant misses the distance by more than is allowed at the cell's centre; where
///     it holds no surface, also in the middles of three faces (the others are its neighbours')
///     and, if cubic, at the centres of its children.
/// The first two are proved for every point of the surface, by geometry (MeshDistance) or by
/// Lipschitz's bound, so that the missed features of the thesis's figure 3.4 cannot occur. A finest
/// cell of edge h errs by at most 0.87 h, since a distance changes no faster than its argument.
///
/// The same for any number of threads.
/// throws  InputError unless the depth is one that an octree can have; ResourceError if it would
///         take more memory than allowed
/// source  Sigg 2006 (thesis), 3.4, with proofs in place of its look-ahead; Frisken et al. 2000
HashedOctree build_adaptive(const ExactDistance& distance, const AdaptiveOptions& options,
                            const Progress& progress = {});

} // namespace isocast
