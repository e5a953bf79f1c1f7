// The failures that the world causes; our own mistakes are assertions (assert.h).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <stdexcept>

namespace isocast {

/// A file, mesh, field or option value that cannot be used. The message names it and the cause;
/// each level that knows more puts a line in front ("while reading grid 'surface' of a.vdb: …").
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Too much memory, disk or address space asked for, or too little given.
struct ResourceError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The user asked to stop (Ctrl-C, a closed window).
struct Interrupted : std::runtime_error {
    Interrupted() : std::runtime_error("interrupted") {}
};

} // namespace isocast
