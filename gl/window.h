// The window of a context of Backend::Window.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/context.h"

struct GLFWwindow;

namespace isocast::gl {

/// For events, by GLFW's functions.
GLFWwindow* window_of(Context& context);

} // namespace isocast::gl
