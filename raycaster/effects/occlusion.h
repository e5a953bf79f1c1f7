// Ambient occlusion, by rays through fields and among primitives.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// throws  ResourceError unless all bricks are at hand
void run_occlusion(FrameContext& frame);

std::vector<gl::ProgramKey> occlusion_programs();

} // namespace isocast
