// Pictures in memory and in files: PNG and multi-channel OpenEXR.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace isocast {

/// Four floats a pixel, the top row first.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<float> rgba;

    const float* pixel(int x, int y) const {
        return rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                  static_cast<std::size_t>(x));
    }
};

/// The bottom row first, as textures have it.
std::vector<float> bottom_up(const Image& image);

/// Writes 8-bit sRGB from linear RGB, without alpha. The file appears whole or not at all.
/// throws  InputError if the folder does not exist, ResourceError if the write fails
void write_png(const Image& linear, const std::filesystem::path& path);

/// One channel of an EXR file.
struct ExrChannel {
    std::vector<float> values; // width * height, top row first
    bool as_half = false;
};

/// Channels by name ("R", "Z", "P.X", …) with the file's attributes.
struct ExrImage {
    int width = 0;
    int height = 0;
    std::map<std::string, ExrChannel> channels;
    std::map<std::string, std::string> strings;
    std::map<std::string, float> floats;
    std::map<std::string, Eigen::Matrix4f> matrices; // acting on column vectors
};

/// One part, ZIP compression. The file appears whole or not at all.
/// throws  as write_png
void write_exr(const ExrImage& image, const std::filesystem::path& path);

} // namespace isocast
