// Signs away from the band of a mesh that is not closed: they may change across a hole.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/winding_number.h"
#include "volume/progress.h"
#include "volume/sparse_field.h"

#include <vector>

namespace isocast {

/// Makes the field's rule for missing blocks (Outside::SignedBackground) give the sign of the
/// winding number everywhere in the box of the blocks, and + beyond it.
///
///   row of blocks     band | - - - (hole above) + + + | band     + where w <= 1/2, - where w > 1/2
///   stored by this                            ^ the first block of each new sign, and those that
///                                               the surface w = 1/2 cuts
///
/// blocks            sorted by z, y, x; those added are inactive throughout, order is kept
/// winding           in voxels from the samples' origin
/// throws            ResourceError if the box has too many blocks for the available memory
void store_outside_signs(FieldBlocks& blocks, const WindingNumber& winding, float background_world,
                         double memory_bytes, const Progress& progress);

} // namespace isocast
