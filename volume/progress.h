// How long work tells how far it is and learns that it should stop.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <functional>
#include <string_view>

namespace isocast {

/// Called now and then, from any thread, with the stage's name and the fraction done in [0, 1].
/// Throws Interrupted to end the work; the caller then sees that exception and no output.
/// An empty function is allowed and means that nobody watches.
using Progress = std::function<void(std::string_view stage, double fraction)>;

} // namespace isocast
