// The closest points of a block's samples.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/sparse_field.h"

namespace isocast {

/// The closest point of the mesh, and what it lies on, for each sample of a block.
struct ClosestBlock {
    /// From the sample to the closest point [world]; 0 where inactive.
    std::array<Eigen::Vector3f, samples_per_block> offset_world;
    /// Faces by number, then edges, then vertices of the cleaned mesh; -1 where inactive.
    std::array<std::int32_t, samples_per_block> feature;
};

} // namespace isocast
