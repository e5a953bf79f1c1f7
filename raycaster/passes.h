// Every pass of a frame, from hits to beauty (DESIGN section 4).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// Every pass there is, in dataflow order. They refer to `frame`, which must outlive them.
std::vector<Pass> declare_passes(FrameContext& frame);

/// Every program that the passes can ask for, up to its strides; for the test that compiles them
/// all.
std::vector<gl::ProgramKey> all_programs();

} // namespace isocast
