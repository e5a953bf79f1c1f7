// What users say of the output: sizes, samples, frames.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/scene_file.h"

namespace isocast {

struct PictureSize {
    int width = 0;
    int height = 0;
};

/// "WxH" in pixels.
/// throws  UsageError; the others too
PictureSize size_from(std::string_view text);

/// A power of two up to 64.
int samples_from(int count);

/// "N": from 0 to N - 1; or "A..B".
FrameRange frames_from(const std::string& text);

/// The file of a frame: `pattern` holds one %d or %04d, which becomes the number.
std::filesystem::path frame_path(const std::filesystem::path& pattern, int number);

} // namespace isocast
