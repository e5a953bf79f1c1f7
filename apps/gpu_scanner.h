// Scan conversion on the GPU, for conversions that ask for it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/convert.h"

#include <filesystem>
#include <vector>

namespace isocast {

/// Makes its context when a band is to be scanned, and gives it up after; whoever has another one
/// makes that current again.
BandScanner gpu_scanner(const std::vector<std::filesystem::path>& shader_folders);

} // namespace isocast
