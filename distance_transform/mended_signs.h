// Signs that distance cannot have, since it changes by no more than one moves.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/sparse_field.h"

#include <functional>

namespace isocast {

/// Mends the signs of active samples that a neighbour contradicts. Distance is 1-Lipschitz:
/// neighbours of different signs are one voxel from the surface together; here two are allowed,
/// since blended distances may be steeper. The winding number decides for them where it is not near
/// 1/2, else most of the six neighbours. The same for any number of threads.
///
/// blocks       sorted by z, y, x; neighbours in missing blocks have no say
/// voxel_world  edge of a voxel, in the unit of the values
/// winding_at   a place in voxels
/// returns      how many changed
std::int64_t mend_signs(FieldBlocks& blocks, float voxel_world,
                        const std::function<double(const Vec3d&)>& winding_at);

} // namespace isocast
