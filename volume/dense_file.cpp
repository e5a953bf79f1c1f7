// What the writers of dense files share: a stream that fails loudly, slabs, axes.
// SPDX-License-Identifier: MPL-2.0
#include "volume/dense_file.h"

#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>

namespace isocast {

namespace {

/// copy_box by parts `depth` deep along z or, in a single layer, along y.
void copy_in_parallel(const FieldSource& field, const IndexBox& box, int depth,
                      std::span<float> out) {
    const int axis = box.size().z() > 1 ? 2 : 1;
    const auto stride = static_cast<std::size_t>(box.sample_count() / box.size()[axis]);
    tbb::parallel_for(0, (box.size()[axis] + depth - 1) / depth, [&](int i) {
        IndexBox part = box;
        part.lo[axis] += i * depth;
        part.hi[axis] = std::min(part.lo[axis] + depth, box.hi[axis]);
        field.copy_box(part, 0,
                       out.subspan(stride * static_cast<std::size_t>(i * depth),
                                   static_cast<std::size_t>(part.sample_count())));
    });
}

} // namespace

static_assert(std::endian::native == std::endian::little, "samples are written as they lie");

RightAngledAxes right_angled_axes(const GridSpace& space, const std::filesystem::path& path) {
    const Vec3d spacing = space.world_from_index.linear().colwise().norm();
    const Mat3d directions = space.world_from_index.linear() * spacing.cwiseInverse().asDiagonal();
    // 1e-6: across a thousand voxels a thousandth of one; rotations from float32 files pass.
    if (!((directions.transpose() * directions - Mat3d::Identity()).cwiseAbs().maxCoeff() < 1e-6))
        throw InputError(
            fmt::format("cannot write {}: the grid's axes are not at right angles, and "
                        "{} files hold no others (NRRD files do)",
                        path.string(), path.extension().string()));
    return {directions, spacing};
}

std::uint64_t dense_byte_count(const FieldSource& field, const std::filesystem::path& path) {
    if (field.extent().is_empty())
        throw InputError(fmt::format("cannot write {}: the field has no samples", path.string()));
    const Index3 size = field.extent().size();
    // 2^60: more than any disk, and 64 bits hold it.
    if (sizeof(float) * size.cast<double>().prod() > 0x1p60)
        throw ResourceError(fmt::format("cannot write {}: {} x {} x {} samples are too many",
                                        path.string(), size.x(), size.y(), size.z()));
    return sizeof(float) * static_cast<std::uint64_t>(field.extent().sample_count());
}

DenseFile::DenseFile(const std::filesystem::path& path, std::uint64_t byte_count)
    : path_(path), file_(path) {
    std::error_code unknown; // then the disk says so itself, later
    const std::filesystem::space_info disk =
        std::filesystem::space(file_.temporary_path().parent_path(), unknown);
    if (!unknown && byte_count > disk.available)
        throw ResourceError(
            fmt::format("cannot write {}: {:.3g} GiB needed, {:.3g} GiB free on that disk",
                        path.string(), static_cast<double>(byte_count) * 0x1p-30,
                        static_cast<double>(disk.available) * 0x1p-30));
    stream_.open(file_.temporary_path(), std::ios::binary);
}

void DenseFile::write_bytes(const char* bytes, std::size_t count) {
    if (!stream_.write(bytes, static_cast<std::streamsize>(count)))
        throw ResourceError(
            fmt::format("cannot write {}: {}", path_.string(), std::strerror(errno)));
}

void DenseFile::write(std::string_view text) {
    write_bytes(text.data(), text.size());
}

void DenseFile::write_samples(const FieldSource& field, const Progress& progress) {
    // Slabs of whole rows and, where they are small enough, of whole layers: 2^23 samples, 32 MiB.
    constexpr std::int64_t slab_samples = std::int64_t{1} << 23;
    // Sparse fields store blocks of 8: parts that deep meet each block once.
    constexpr int part_depth = 8;
    const IndexBox box = field.extent();
    const Index3 size = box.size();
    const std::int64_t layer = std::int64_t{size.x()} * size.y();
    const auto fitting = [&](std::int64_t row_or_layer, int most) {
        const auto count =
            static_cast<int>(std::clamp<std::int64_t>(slab_samples / row_or_layer, 1, most));
        return count < most && count > part_depth ? count / part_depth * part_depth : count;
    };
    const Index3 step(size.x(), fitting(size.x(), size.y()), fitting(layer, size.z()));
    std::vector<float> slab;
    std::int64_t written = 0;
    for (int z = 0; z < size.z(); z += step.z())
        for (int y = 0; y < size.y(); y += step.y()) {
            const Index3 lo = box.lo + Index3(0, y, z);
            const IndexBox piece = intersection(box, {lo, lo + step});
            slab.resize(static_cast<std::size_t>(piece.sample_count()));
            copy_in_parallel(field, piece, part_depth, slab);
            write_bytes(reinterpret_cast<const char*>(slab.data()), slab.size() * sizeof(float));
            written += piece.sample_count();
            if (progress)
                progress("write",
                         static_cast<double>(written) / static_cast<double>(box.sample_count()));
        }
}

void DenseFile::commit() {
    stream_.close();
    if (!stream_)
        throw ResourceError(
            fmt::format("cannot write {}: {}", path_.string(), std::strerror(errno)));
    file_.commit();
}

} // namespace isocast
