// Pictures in memory, and those that users give.
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

    bool operator==(const Image&) const = default;

    const float* pixel(int x, int y) const {
        return rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                  static_cast<std::size_t>(x));
    }
};

/// The bottom row first, as textures have it.
std::vector<float> bottom_up(const Image& image);

/// sRGB's transfer function and its inverse, of a channel in [0, 1].
/// source  IEC 61966-2-1
float srgb_encoded(float linear);
double srgb_decoded(double srgb);
/// From 8 bits.
float linear_from_srgb(int byte);

/// A PNG or OpenEXR file by its extension, as linear RGB and coverage: of PNG the sRGB colours, of
/// OpenEXR the channels R, G and B, or Y.
/// throws  InputError that names the file and the cause
Image read_picture(const std::filesystem::path& path);

/// One channel of an EXR file.
struct ExrChannel {
    std::vector<float> values; // width * height, top row first
    bool as_half = false;
};

/// An EXR file's, or some rows of it: channels by name ("R", "Z", "P.X", …) with the
/// file's attributes.
struct ExrImage {
    int width = 0;
    int height = 0;
    std::map<std::string, ExrChannel> channels;
    std::map<std::string, std::string> strings;
    std::map<std::string, float> floats;
    std::map<std::string, Eigen::Matrix4f> matrices; // acting on column vectors
    std::vector<std::string> views = {};             // of a multi-view file, the default one first
};

} // namespace isocast
