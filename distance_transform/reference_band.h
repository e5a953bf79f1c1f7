// What the thesis's own methods hand back, and how a band differs from the exact one.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/sparse_field.h"

#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace isocast {

struct ReferenceBand {
    /// Sorted by z, y, x; coordinates relative to the lattice's anchor. Each has an active sample.
    FieldBlocks blocks;
    std::int64_t distance_evaluations = 0;
};

/// Distances at the samples of a block [voxels], x fastest; infinite where no polyhedron reached.
struct BlockDistances {
    std::array<double, samples_per_block> signed_voxels;

    BlockDistances() { signed_voxels.fill(std::numeric_limits<double>::infinity()); }
    /// Keeps `candidate` if it is nearer to the surface than what is known.
    void offer(int sample, double candidate) {
        if (std::abs(candidate) < std::abs(signed_voxels[sample]))
            signed_voxels[sample] = candidate;
    }
    /// A block whose samples with |d| <= half width are active, the others ± background.
    FieldBlock to_block(const Index3& coordinate, double half_width_voxels,
                        double voxel_size_world) const;
};

/// How a band differs from the exact one, sample by sample.
struct BandErrors {
    std::int64_t samples = 0; // active in the exact band
    std::int64_t missing = 0; // of these, inactive in the other band
    std::int64_t too_far = 0; // active in both, but further than exact by more than 1e-5 voxel
    std::int64_t wrong_signs =
        0;                   // active in both, where |d| > 1e-9 voxel; nearer is on the surface
    std::int64_t extra = 0;  // active in the other band only
    double worst_voxels = 0; // greatest error of |d| where active in both
};

/// exact, other  sorted by z, y, x, coordinates relative to the same sample
BandErrors band_errors(std::span<const FieldBlock> exact, std::span<const FieldBlock> other,
                       double voxel_size_world);

} // namespace isocast
