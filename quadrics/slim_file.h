// Files of SLIM surfaces (.slim); docs/slim.md describes the format.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/slim.h"

#include <filesystem>

namespace isocast {

/// By its name.
bool is_slim_file(const std::filesystem::path& path);

/// The file appears whole or not at all; the colour is not written.
/// throws  InputError as check(), or if the folder does not exist; ResourceError if it cannot be
///         written
void write_slim(const SlimSurface& surface, const std::filesystem::path& path);

/// throws  InputError that names the file and what is wrong with it: of another kind or version,
///         cut short or longer than it says, damaged, or with a patch that check() refuses
SlimSurface read_slim(const std::filesystem::path& path);

} // namespace isocast
