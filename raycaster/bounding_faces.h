// The bounding geometry of the active blocks: their faces next to inactive blocks (thesis section
// 6.3.1).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/blocks.h"

#include <Eigen/Core>

#include <vector>

namespace isocast {

/// One face for each instance: xyz the block's low corner in local coordinates [voxels], w the
/// face: 2 * axis for the low one, 2 * axis + 1 for the high one.
std::vector<Eigen::Vector4i> bounding_faces(const ActiveBlocks& blocks,
                                            const Index3& local_origin_index);

} // namespace isocast
