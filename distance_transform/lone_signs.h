// Signs that the distance's slope rules out.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/sparse_field.h"

namespace isocast {

/// Turns the sign of active samples that most of their six neighbours contradict. Distance is
/// 1-Lipschitz: neighbours of different signs are one voxel from the surface together; here two are
/// allowed, since blended distances may be steeper. The same for any order of samples and threads.
///
/// blocks       sorted by z, y, x; neighbours in missing blocks have no say
/// voxel_world  edge of a voxel, in the unit of the values
/// returns      how many were turned
std::int64_t turn_lone_signs(FieldBlocks& blocks, float voxel_world);

} // namespace isocast
