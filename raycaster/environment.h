// Light from all directions as a texture.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// What a built-in environment shows in a direction of unit length; linear RGB.
Vec3d builtin_environment(const Environment& environment, const Vec3d& direction_world);

/// Binds the environment of the scene for shaders/shading/environment/environment.glsl.
void bind_environment(const FrameContext& frame);

} // namespace isocast
