// SPDX-License-Identifier: MPL-2.0
#include "raycaster/image_files.h"

#include "volume/atomic_file.h"
#include "volume/errors.h"

#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMatrixAttribute.h>
#include <ImfMultiView.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <optional>
#include <utility>

namespace isocast {

namespace {

/// To 8 bits.
png_byte srgb_byte(float linear) {
    // NaN becomes 0: the comparison is false for it.
    const float c = linear > 0 ? std::min(linear, 1.0f) : 0.0f;
    return static_cast<png_byte>(std::lround(255 * srgb_encoded(c)));
}

[[noreturn]] void fail(const std::filesystem::path& path, const char* cause) {
    throw ResourceError(fmt::format("cannot write {}: {}", path.string(), cause));
}

} // namespace

struct PngFile::State {
    State(const std::filesystem::path& file_path, bool with_alpha)
        : path(file_path), output(path), has_alpha(with_alpha) {}
    ~State() {
        png_destroy_write_struct(&png, &info);
        if (file) std::fclose(file);
    }
    /// What libpng does, as an exception where it jumps. It says only "Write Error"; the system
    /// knows why.
    template<class Act>
    void call(Act act) {
        errno = 0;
        if (setjmp(png_jmpbuf(png)) != 0)
            fail(path, errno != 0 ? std::strerror(errno) : "libpng failed");
        act();
    }

    std::filesystem::path path;
    AtomicFile output;
    bool has_alpha;
    std::FILE* file = nullptr;
    png_structp png = nullptr;
    png_infop info = nullptr;
};

PngFile::PngFile(const std::filesystem::path& path, int width, int height, bool has_alpha)
    : state_(std::make_unique<State>(path, has_alpha)) {
    State& s = *state_;
    s.file = std::fopen(s.output.temporary_path().c_str(), "wb");
    if (!s.file) fail(path, std::strerror(errno));
    // It would print; the message is ours.
    const auto jump = [](png_structp png, png_const_charp) { png_longjmp(png, 1); };
    const auto ignore = [](png_structp, png_const_charp) {};
    s.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, jump, ignore);
    s.info = s.png ? png_create_info_struct(s.png) : nullptr;
    if (!s.info) throw std::bad_alloc();
    s.call([&] {
        png_init_io(s.png, s.file);
        png_set_IHDR(s.png, s.info, static_cast<png_uint_32>(width),
                     static_cast<png_uint_32>(height), 8,
                     has_alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB(s.png, s.info, PNG_sRGB_INTENT_PERCEPTUAL);
        png_write_info(s.png, s.info);
    });
}

PngFile::~PngFile() = default;

void PngFile::write(const Image& rows) {
    const std::size_t channels = state_->has_alpha ? 4 : 3;
    std::vector<png_byte> bytes(static_cast<std::size_t>(rows.width) * channels);
    for (int y = 0; y < rows.height; ++y) {
        for (int x = 0; x < rows.width; ++x) {
            const float* pixel = rows.pixel(x, y);
            png_byte* out = bytes.data() + static_cast<std::size_t>(x) * channels;
            // PNG's colours are not multiplied by alpha.
            const float scale = state_->has_alpha && pixel[3] > 0 ? 1 / pixel[3] : 1;
            for (std::size_t c = 0; c < 3; ++c) out[c] = srgb_byte(scale * pixel[c]);
            if (state_->has_alpha)
                out[3] = static_cast<png_byte>(std::lround(255 * std::clamp(pixel[3], 0.0f, 1.0f)));
        }
        state_->call([&] { png_write_row(state_->png, bytes.data()); });
    }
}

void PngFile::finish() {
    State& s = *state_;
    s.call([&] { png_write_end(s.png, s.info); });
    if (std::fclose(std::exchange(s.file, nullptr)) != 0) fail(s.path, std::strerror(errno));
    s.output.commit();
}

void write_png(const Image& linear, const std::filesystem::path& path) {
    PngFile file(path, linear.width, linear.height, false);
    file.write(linear);
    file.finish();
}

struct ExrFile::State {
    explicit State(const std::filesystem::path& file_path) : path(file_path), output(path) {}
    template<class Act>
    void call(Act act) {
        errno = 0;
        try {
            act();
        } catch (const std::exception& error) {
            // Its message names the temporary file; where the system knows the cause, that is
            // enough.
            fail(path, errno != 0 ? std::strerror(errno) : error.what());
        }
    }

    std::filesystem::path path;
    AtomicFile output;
    std::optional<Imf::OutputFile> file;
    int rows_written = 0;
};

ExrFile::ExrFile(const std::filesystem::path& path, int width, int height, const ExrImage& like)
    : state_(std::make_unique<State>(path)) {
    Imf::Header header(width, height);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const auto& [name, channel] : like.channels)
        header.channels().insert(name, Imf::Channel(channel.as_half ? Imf::HALF : Imf::FLOAT));
    if (!like.views.empty()) Imf::addMultiView(header, like.views);
    for (const auto& [name, value] : like.strings) header.insert(name, Imf::StringAttribute(value));
    for (const auto& [name, value] : like.floats) header.insert(name, Imf::FloatAttribute(value));
    for (const auto& [name, value] : like.matrices) {
        // OpenEXR multiplies row vectors from the left: its matrices are the transposed ones.
        Imath::M44f transposed;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) transposed[i][j] = value(j, i);
        header.insert(name, Imf::M44fAttribute(transposed));
    }
    state_->call([&] { state_->file.emplace(state_->output.temporary_path().c_str(), header); });
}

ExrFile::~ExrFile() = default;

void ExrFile::write(const ExrImage& rows) {
    Imf::FrameBuffer frame;
    // OpenEXR reads half channels from half memory.
    std::vector<std::vector<half>> halves;
    halves.reserve(rows.channels.size());
    const auto insert = [&](const std::string& name, Imf::PixelType type, auto* values) {
        // Slices start at the picture's first row.
        const std::size_t row = sizeof(*values) * static_cast<std::size_t>(rows.width);
        const std::size_t above = row * static_cast<std::size_t>(state_->rows_written);
        frame.insert(
            name, Imf::Slice(type, reinterpret_cast<char*>(values) - above, sizeof(*values), row));
    };
    for (const auto& [name, channel] : rows.channels)
        if (channel.as_half)
            insert(name, Imf::HALF,
                   halves.emplace_back(channel.values.begin(), channel.values.end()).data());
        else
            insert(name, Imf::FLOAT, const_cast<float*>(channel.values.data()));
    state_->call([&] {
        state_->file->setFrameBuffer(frame);
        state_->file->writePixels(rows.height);
    });
    state_->rows_written += rows.height;
}

void ExrFile::finish() {
    state_->file.reset();
    state_->output.commit();
}

ExrImage stereo(ExrImage left, ExrImage right) {
    ExrImage out{.width = left.width,
                 .height = left.height,
                 .matrices = std::move(left.matrices),
                 .views = {"left", "right"}};
    for (int i = 0; ExrImage * view : {&left, &right}) {
        for (auto& [name, channel] : view->channels)
            out.channels.emplace(Imf::insertViewName(name, out.views, i), std::move(channel));
        ++i;
    }
    for (const auto& [name, matrix] : right.matrices) out.matrices.emplace(name + ".right", matrix);
    return out;
}

void write_exr(const ExrImage& image, const std::filesystem::path& path) {
    ExrFile file(path, image.width, image.height, image);
    file.write(image);
    file.finish();
}

} // namespace isocast
