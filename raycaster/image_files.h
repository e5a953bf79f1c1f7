// Picture files, PNG and multi-channel OpenEXR, written from the top row down, so that memory is
// needed for some rows at a time.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/image.h"

#include <memory>

namespace isocast {

/// An 8-bit sRGB PNG file. It appears whole, by finish(), or not at all.
class PngFile {
public:
    /// has_alpha  then rows are linear RGB multiplied by coverage, and coverage; else linear RGB
    /// throws     InputError if the folder does not exist, ResourceError if the write fails; the
    ///            others too
    PngFile(const std::filesystem::path& path, int width, int height, bool has_alpha);
    ~PngFile();
    /// The next rows.
    void write(const Image& rows);
    /// Call after all rows.
    void finish();

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Writes a PNG without alpha from linear RGB.
/// throws  as PngFile
void write_png(const Image& linear, const std::filesystem::path& path);

/// An EXR file of one part, ZIP compression. It appears whole, by finish(), or not at all.
class ExrFile {
public:
    /// like    has the file's channels and attributes; its size and values do not matter
    /// throws  as PngFile; the others too
    ExrFile(const std::filesystem::path& path, int width, int height, const ExrImage& like);
    ~ExrFile();
    /// The next rows, of the same channels.
    void write(const ExrImage& rows);
    /// Call after all rows.
    void finish();

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// A file of the views "left", the default, and "right", whose channels have names as OpenEXR's
/// multi-view files have them: "R" and "right.R", "P.left.X" and "P.right.X". Matrices of the right
/// one end in ".right".
ExrImage stereo(ExrImage left, ExrImage right);

/// throws  as PngFile
void write_exr(const ExrImage& image, const std::filesystem::path& path);

} // namespace isocast
