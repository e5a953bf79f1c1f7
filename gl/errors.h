// What goes wrong with OpenGL: no context, a shader that does not compile, an error in a call.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <stdexcept>

namespace isocast::gl {

struct GlError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// No context could be made at all. The message lists what was tried and why each failed.
struct NoContextError : GlError {
    using GlError::GlError;
};

} // namespace isocast::gl
