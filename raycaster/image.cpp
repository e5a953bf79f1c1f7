// SPDX-License-Identifier: MPL-2.0
#include "raycaster/image.h"

#include "volume/errors.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace isocast {

namespace {

Image read_png(const std::filesystem::path& path) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    std::vector<png_byte> bytes;
    bool is_read = png_image_begin_read_from_file(&png, path.c_str()) != 0;
    if (is_read) {
        png.format = PNG_FORMAT_RGBA;
        bytes.resize(PNG_IMAGE_SIZE(png));
        is_read = png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr) != 0;
    }
    if (!is_read) throw InputError(fmt::format("{}: {}", path.string(), png.message));
    std::array<float, 256> linear;
    for (int i = 0; i < 256; ++i) linear[static_cast<std::size_t>(i)] = linear_from_srgb(i);
    Image image{static_cast<int>(png.width), static_cast<int>(png.height), {}};
    image.rgba.reserve(bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i)
        image.rgba.push_back(i % 4 == 3 ? float(bytes[i]) / 255 : linear[bytes[i]]);
    return image;
}

Image read_exr(const std::filesystem::path& path) {
    try {
        Imf::InputFile file(path.c_str());
        const Imath::Box2i window = file.header().dataWindow();
        Image image{window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, {}};
        const Imf::ChannelList& channels = file.header().channels();
        const bool is_grey = channels.findChannel("Y") && !channels.findChannel("R");
        const auto row = static_cast<std::size_t>(image.width) * 4;
        image.rgba.resize(row * static_cast<std::size_t>(image.height));
        Imf::FrameBuffer frame;
        for (std::size_t c = 0; c < 4; ++c) {
            const std::string name = is_grey && c < 3 ? "Y" : std::string(1, "RGBA"[c]);
            if (c < 3 && !channels.findChannel(name)) {
                std::vector<std::string> present;
                for (auto i = channels.begin(); i != channels.end(); ++i)
                    present.emplace_back(i.name());
                throw InputError(
                    fmt::format("no channel {} (has: {})", name, fmt::join(present, ", ")));
            }
            if (is_grey && (c == 1 || c == 2)) continue;
            char* first = reinterpret_cast<char*>(image.rgba.data() + c) -
                          sizeof(float) * (4 * std::ptrdiff_t{window.min.x} +
                                           std::ptrdiff_t(row) * window.min.y);
            frame.insert(name, Imf::Slice(Imf::FLOAT, first, 4 * sizeof(float), row * sizeof(float),
                                          1, 1, 1)); // an alpha that is missing is 1
        }
        file.setFrameBuffer(frame);
        file.readPixels(window.min.y, window.max.y);
        if (is_grey)
            for (std::size_t i = 0; i < image.rgba.size(); i += 4)
                image.rgba[i + 1] = image.rgba[i + 2] = image.rgba[i];
        if (!std::ranges::all_of(image.rgba, [](float value) { return std::isfinite(value); }))
            throw InputError("a pixel is no finite number");
        return image;
    } catch (const std::exception& error) {
        throw InputError(fmt::format("{}: {}", path.string(), error.what()));
    }
}

} // namespace

std::vector<float> bottom_up(const Image& image) {
    std::vector<float> texels;
    texels.reserve(image.rgba.size());
    for (int y = image.height - 1; y >= 0; --y)
        texels.insert(texels.end(), image.pixel(0, y), image.pixel(0, y) + 4 * image.width);
    return texels;
}

double srgb_decoded(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

float srgb_encoded(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float linear_from_srgb(int byte) {
    return static_cast<float>(srgb_decoded(byte / 255.0));
}

Image read_picture(const std::filesystem::path& path) {
    if (!std::filesystem::is_regular_file(path))
        throw InputError(fmt::format("{}: no such file", path.string()));
    if (path.extension() == ".png") return read_png(path);
    if (path.extension() == ".exr") return read_exr(path);
    throw InputError(fmt::format("{}: no picture that can be read (.png, .exr)", path.string()));
}

} // namespace isocast
