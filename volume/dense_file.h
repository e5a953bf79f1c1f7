// What the writers of dense files share: a stream that fails loudly, slabs, axes.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/atomic_file.h"
#include "volume/field_source.h"
#include "volume/progress.h"

#include <cstdint>
#include <fstream>
#include <string_view>

namespace isocast {

/// A grid's axes where they are at right angles: a turn (or mirror image) and a length for each.
struct RightAngledAxes {
    Mat3d directions; // columns: where each index axis points in the world, unit length
    Vec3d spacing_world;
};

/// throws  InputError that names `path` if the axes are sheared
RightAngledAxes right_angled_axes(const GridSpace& space, const std::filesystem::path& path);

/// Size in bytes of the extent's samples.
/// throws  InputError if the extent is empty
std::uint64_t dense_byte_count(const FieldSource& field, const std::filesystem::path& path);

/// One file on its way to disk.
class DenseFile {
public:
    /// byte_count  how large the file will be, about
    /// throws      InputError as AtomicFile, ResourceError if the disk has less room than that
    DenseFile(const std::filesystem::path& path, std::uint64_t byte_count);

    void write(std::string_view text);
    /// Every sample of the field's extent, x fastest; stage "write" of the progress.
    void write_samples(const FieldSource& field, const Progress& progress);
    /// throws  ResourceError if anything could not be written
    void commit();

private:
    void write_bytes(const char* bytes, std::size_t count);

    std::filesystem::path path_;
    AtomicFile file_;
    std::ofstream stream_;
};

} // namespace isocast
