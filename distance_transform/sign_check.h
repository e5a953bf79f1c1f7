// Whether the signs of a band fit together, and what to do if not.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/block_signs.h"
#include "volume/progress.h"

#include <span>

namespace isocast {

/// False where two neighbouring samples differ in sign although both are too far from the surface
/// for it to pass between them, where a row of missing blocks ends with another sign than it
/// begins, or where it leaves the box inside: the surface intersects itself, or a shell is inside
/// out.
///
/// negative  samples of each block, if they are known already; else empty
bool signs_are_consistent(const FieldBlocks& blocks, std::span<const SampleBits> negative,
                          double voxel_size_world);

/// Gives all samples the sign of the winding number, and keeps their distances.
///
/// winding  in voxels from the samples' origin
void sign_by_winding_number(FieldBlocks& blocks, const WindingNumber& winding,
                            double voxel_size_world, float background_world,
                            const Progress& progress);

} // namespace isocast
