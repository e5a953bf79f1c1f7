// Any field as sparse blocks, as files store them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/progress.h"
#include "volume/sparse_field.h"

namespace isocast {

/// Copies `field` into 8^3 blocks.
///
/// With a band (FieldSource::half_width_world) it is signed and keeps the blocks that hold a sample
/// with |value| < half width, and those of which the kept ones do not tell the sign. Without a band
/// it keeps every block of the active boxes, the samples of the extent active, the background being
/// the greatest |value| at the extent's border.
SparseField to_sparse(const FieldSource& field, const Progress& progress = {});

} // namespace isocast
