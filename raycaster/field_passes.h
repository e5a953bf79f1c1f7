// The passes that read the field: hits, gradients, curvatures.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// Whether the pass "raycast" can write gradients too: with all bricks at hand, of one filter, and
/// pixels that are drawn once.
bool can_fuse_gradient(const FrameContext& frame);

void run_bounds(FrameContext& frame);
void run_raycast(FrameContext& frame);
/// order  of raycast/derivatives.frag: 1 for the gradient, 2 for curvatures, 3 for directions
void run_derivatives(FrameContext& frame, FrameImage image, int order);

/// Every program that these can ask for, up to its strides.
std::vector<gl::ProgramKey> field_programs();

} // namespace isocast
