// SPDX-License-Identifier: MPL-2.0
#include "raycaster/image.h"

#include "volume/atomic_file.h"
#include "volume/errors.h"

#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace isocast {

namespace {

/// IEC 61966-2-1 transfer function, to 8 bits.
png_byte srgb_byte(float linear) {
    // NaN becomes 0: the comparison is false for it.
    const float c = linear > 0 ? std::min(linear, 1.0f) : 0.0f;
    const float s = c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
    return static_cast<png_byte>(std::lround(255 * s));
}

} // namespace

std::vector<float> bottom_up(const Image& image) {
    std::vector<float> texels;
    texels.reserve(image.rgba.size());
    for (int y = image.height - 1; y >= 0; --y)
        texels.insert(texels.end(), image.pixel(0, y), image.pixel(0, y) + 4 * image.width);
    return texels;
}

void write_png(const Image& linear, const std::filesystem::path& path) {
    AtomicFile output(path);
    std::FILE* file = std::fopen(output.temporary_path().c_str(), "wb");
    if (!file)
        throw ResourceError(
            fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
    std::vector<png_byte> bytes(static_cast<std::size_t>(linear.width) *
                                static_cast<std::size_t>(linear.height) * 3);
    for (std::size_t i = 0; i < bytes.size() / 3; ++i)
        for (std::size_t channel = 0; channel < 3; ++channel)
            bytes[3 * i + channel] = srgb_byte(linear.rgba[4 * i + channel]);

    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(linear.width);
    image.height = static_cast<png_uint_32>(linear.height);
    image.format = PNG_FORMAT_RGB;
    errno = 0;
    const bool written = png_image_write_to_stdio(&image, file, 0, bytes.data(), 0, nullptr) != 0;
    const int write_errno = errno;
    const bool closed = std::fclose(file) == 0;
    // libpng says only "Write Error"; the system knows why.
    if (!written || !closed)
        throw ResourceError(fmt::format("cannot write {}: {}", path.string(),
                                        std::strerror(written ? errno : write_errno)));
    output.commit();
}

void write_exr(const ExrImage& image, const std::filesystem::path& path) {
    Imf::Header header(image.width, image.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer frame;
    // OpenEXR reads half channels from half memory.
    std::vector<std::vector<half>> halves;
    halves.reserve(image.channels.size());
    const auto row = static_cast<std::size_t>(image.width);
    for (const auto& [name, channel] : image.channels) {
        if (channel.as_half) {
            halves.emplace_back(channel.values.begin(), channel.values.end());
            header.channels().insert(name, Imf::Channel(Imf::HALF));
            frame.insert(name, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(halves.back().data()),
                                          sizeof(half), row * sizeof(half)));
        } else {
            header.channels().insert(name, Imf::Channel(Imf::FLOAT));
            frame.insert(
                name, Imf::Slice(Imf::FLOAT,
                                 reinterpret_cast<char*>(const_cast<float*>(channel.values.data())),
                                 sizeof(float), row * sizeof(float)));
        }
    }
    for (const auto& [name, value] : image.strings)
        header.insert(name, Imf::StringAttribute(value));
    for (const auto& [name, value] : image.floats) header.insert(name, Imf::FloatAttribute(value));
    for (const auto& [name, value] : image.matrices) {
        // OpenEXR multiplies row vectors from the left: its matrices are the transposed ones.
        Imath::M44f transposed;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) transposed[i][j] = value(j, i);
        header.insert(name, Imf::M44fAttribute(transposed));
    }

    AtomicFile output(path);
    errno = 0;
    try {
        Imf::OutputFile file(output.temporary_path().c_str(), header);
        file.setFrameBuffer(frame);
        file.writePixels(image.height);
    } catch (const std::exception& error) {
        // Its message names the temporary file; where the system knows the cause, that is enough.
        throw ResourceError(fmt::format("cannot write {}: {}", path.string(),
                                        errno != 0 ? std::strerror(errno) : error.what()));
    }
    output.commit();
}

} // namespace isocast
