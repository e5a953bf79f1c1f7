// The ways to a context, one .cpp each; internal to gl/.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/context.h"

#include <vector>

namespace isocast::gl {

/// Each returns a context, or null after adding to `failures` one line for each way it tried.
std::unique_ptr<Context> make_egl_context(std::vector<std::string>& failures);
std::unique_ptr<Context> make_osmesa_context(std::vector<std::string>& failures);
std::unique_ptr<Context> make_window_context(const ContextOptions& options,
                                             std::vector<std::string>& failures);

/// Contexts report errors in builds with assertions.
#ifdef ISOCAST_CHECKED
inline constexpr bool reports_errors = true;
#else
inline constexpr bool reports_errors = false;
#endif

} // namespace isocast::gl
