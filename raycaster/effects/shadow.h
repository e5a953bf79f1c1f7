// The shadows of one light.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// From where the light sees a box: orthographic, `pixels` along the longer side, the
/// outermost texels empty.
///
/// box_world     its eight corners, one the mirror image of another in the middle
/// margin_world  how far the surface may reach beyond the box
LightView light_view(const Light& light, const Camera& viewer, int pixels,
                     const std::array<Vec3d, 8>& box_world, double margin_world);

/// Casts the rays of frame.light, and keeps how far they go.
void run_shadow_map(FrameContext& frame);
/// Of shaders/shading/shadow/shadow.glsl, of frame.light.
void set_shadow_uniforms(const gl::Program& program, const FrameContext& frame);
/// Of the casting light.
void run_shadow(FrameContext& frame);

std::vector<gl::ProgramKey> shadow_programs();

} // namespace isocast
