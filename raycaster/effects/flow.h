// Lines along a principal direction, as a factor of the surface's colour.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// What flow_noise and flow need.
std::vector<Pass> flow_passes(FrameContext& frame);
std::vector<gl::ProgramKey> flow_programs();

/// Of a line, to either side, of one pixel each.
int step_count(const Flow& flow);

/// throws  InputError, naming what cannot be drawn
void check(const Flow& flow);

} // namespace isocast
