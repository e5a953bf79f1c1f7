// Bricks of 32^3 samples with the apron that the tricubic filter needs (thesis section 6.2.2).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/blocks.h"

namespace isocast {

/// Points along a brick's edge that the brick serves, in voxels.
inline constexpr int brick_size = 32;
/// Samples along a stored brick's edge: one more below and two more above.
inline constexpr int brick_samples = brick_size + filter_support_below + filter_support_above;

/// Bricks that hold an active block: brick b serves the points 32 b <= p_index < 32 (b + 1).
/// Sorted by z, y, x; each once.
std::vector<Index3> bricks_of(const ActiveBlocks& blocks);

/// Samples 32 b - 1 … 32 b + 33 per axis, x fastest.
/// out  brick_samples^3 values
void cut_brick(const FieldSource& field, const Index3& brick, std::span<float> out);

} // namespace isocast
