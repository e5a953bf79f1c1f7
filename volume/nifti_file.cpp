// NIfTI-1 files, the header and the samples in one; read only.
// SPDX-License-Identifier: MPL-2.0
#include "volume/inflater.h"
#include "volume/volume_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace isocast {

namespace {

constexpr std::size_t header_bytes = 348;
/// Of the samples, where the header is followed by the four bytes that announce extensions.
constexpr int least_offset = 352;

/// The header's bytes. Fields are named by their byte offsets, as nifti1.h lists them.
class NiftiBytes {
public:
    NiftiBytes(std::span<const std::byte> file, const std::filesystem::path& path) {
        const bool is_compressed =
            file.size() >= 2 && file[0] == std::byte{0x1f} && file[1] == std::byte{0x8b};
        if (is_compressed) {
            Inflater(file, path.string()).read(bytes_);
        } else {
            if (file.size() < header_bytes)
                cannot_read(path, fmt::format("not a NIfTI file: {} bytes, its header has {}",
                                              file.size(), header_bytes));
            std::ranges::copy(file.first(header_bytes), bytes_.begin());
        }
        if (at<std::int32_t>(0) == static_cast<std::int32_t>(header_bytes)) return;
        byte_order_ =
            std::endian::native == std::endian::little ? std::endian::big : std::endian::little;
        const auto size = at<std::int32_t>(0);
        if (size == 540 || size == 0x1c020000)
            cannot_read(path, "NIfTI-2; only NIfTI-1 can be read");
        if (size != static_cast<std::int32_t>(header_bytes))
            cannot_read(path, "not a NIfTI file: its first number is not the header's size");
    }

    template<class Number>
    Number at(std::size_t offset) const {
        std::array<std::byte, sizeof(Number)> bytes;
        std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), bytes.size(),
                    bytes.begin());
        if (byte_order_ != std::endian::native) std::ranges::reverse(bytes);
        return std::bit_cast<Number>(bytes);
    }
    double number(std::size_t offset) const { return at<float>(offset); }
    std::string text(std::size_t offset, std::size_t size) const {
        const char* const first = reinterpret_cast<const char*>(&bytes_[offset]);
        std::string text(first, ::strnlen(first, size));
        std::ranges::replace_if(
            text, [](unsigned char c) { return c < 0x20 || c > 0x7e; }, '?');
        return text;
    }
    std::endian byte_order() const { return byte_order_; }

private:
    std::array<std::byte, header_bytes> bytes_{};
    std::endian byte_order_ = std::endian::native;
};

SampleType sample_type(int code, const std::filesystem::path& path) {
    switch (code) {
    case 2:
        return SampleType::UInt8;
    case 4:
        return SampleType::Int16;
    case 8:
        return SampleType::Int32;
    case 16:
        return SampleType::Float;
    case 64:
        return SampleType::Double;
    case 256:
        return SampleType::Int8;
    case 512:
        return SampleType::UInt16;
    case 768:
        return SampleType::UInt32;
    }
    cannot_read(path, fmt::format("datatype {} cannot be read (known: 2 uint8, 4 int16, 8 int32, "
                                  "16 float, 64 double, 256 int8, 512 uint16, 768 uint32)",
                                  code));
}

Index3 size_of(const NiftiBytes& bytes, const std::filesystem::path& path) {
    const auto dim = [&](int i) { return int{bytes.at<std::int16_t>(std::size_t(40 + 2 * i))}; };
    if (dim(0) < 3 || dim(0) > 7)
        cannot_read(path, fmt::format("dim: {} dimensions; only volumes of 3 can be read", dim(0)));
    for (int i = 1; i <= dim(0); ++i) {
        if (dim(i) < 1) cannot_read(path, fmt::format("dim[{}]: {} samples", i, dim(i)));
        if (i > 3 && dim(i) > 1)
            cannot_read(path, fmt::format("dim[{}]: {} volumes in one file; only one can be read",
                                          i, dim(i)));
    }
    return {dim(1), dim(2), dim(3)};
}

/// Method 2 of nifti1.h: a rotation as a unit quaternion, the spacing, and a sign of the third
/// axis.
Eigen::Affine3d qform_of(const NiftiBytes& bytes, const Vec3d& spacing,
                         const std::filesystem::path& path) {
    double b = bytes.number(256);
    double c = bytes.number(260);
    double d = bytes.number(264);
    // Rounding may take b, c, d of a half turn past unit length; more than that is no quaternion.
    const double length = b * b + c * c + d * d;
    if (!(length < 1 + 1e-5)) // 1e-5: a hundred times what float32 rounds
        cannot_read(path, fmt::format("qform: quaternion ({}, {}, {}) is longer than 1", b, c, d));
    const double a = std::sqrt(std::max(0.0, 1 - length));
    const Mat3d turn = Eigen::Quaterniond(a, b, c, d).normalized().toRotationMatrix();
    const double third = bytes.number(76) < 0 ? -1 : 1; // pixdim[0]
    Eigen::Affine3d map = Eigen::Affine3d::Identity();
    map.linear() = turn * (spacing.array() * Eigen::Array3d(1, 1, third)).matrix().asDiagonal();
    map.translation() = Vec3d(bytes.number(268), bytes.number(272), bytes.number(276));
    return map;
}

/// Method 3: the rows of the map.
Eigen::Affine3d sform_of(const NiftiBytes& bytes) {
    Eigen::Affine3d map = Eigen::Affine3d::Identity();
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            map(row, column) = bytes.number(std::size_t(280 + 16 * row + 4 * column));
    return map;
}

Vec3d spacing_of(const NiftiBytes& bytes, const std::filesystem::path& path) {
    const Vec3d spacing(bytes.number(80), bytes.number(84), bytes.number(88));
    if (!(spacing.minCoeff() > 0) || !spacing.allFinite())
        cannot_read(path, fmt::format("pixdim: spacing {} x {} x {} is not above 0", spacing.x(),
                                      spacing.y(), spacing.z()));
    return spacing;
}

} // namespace

VolumeHeader nifti_header(const std::filesystem::path& path) {
    const MappedFile file(path);
    const NiftiBytes bytes(file.bytes(), path);
    if (const std::string magic = bytes.text(344, 4); magic != "n+1")
        cannot_read(path, magic == "ni1"
                              ? "its samples are in another file (.img); only .nii files "
                                "that hold both can be read"
                              : "not a NIfTI file: its magic text is not n+1");
    VolumeHeader header;
    header.data_path = path;
    header.type = sample_type(bytes.at<std::int16_t>(70), path);
    header.byte_order = bytes.byte_order();
    header.size = size_of(bytes, path);

    const double offset = bytes.number(108);
    if (!(offset >= least_offset && offset < 0x1p31) || offset != std::floor(offset))
        cannot_read(path, fmt::format("vox_offset: {} is no byte after the header", offset));
    header.is_compressed = file.bytes()[0] == std::byte{0x1f} && file.bytes()[1] == std::byte{0x8b};
    if (header.is_compressed)
        header.skip_decompressed = static_cast<std::uint64_t>(offset);
    else
        header.skip = static_cast<std::int64_t>(offset);

    // A slope of 0 means none, and so does NaN, which nibabel writes.
    const double slope = bytes.number(112);
    const double intercept = bytes.number(116);
    if (slope != 0 && !std::isnan(slope)) {
        if (!std::isfinite(slope) || !std::isfinite(intercept))
            cannot_read(path, fmt::format("scl_slope {} and scl_inter {} are no finite numbers",
                                          slope, intercept));
        header.slope = slope;
        header.intercept = intercept;
    }

    const bool has_sform = bytes.at<std::int16_t>(254) > 0;
    const bool has_qform = bytes.at<std::int16_t>(252) > 0;
    Eigen::Affine3d& map = header.space.world_from_index;
    if (has_sform)
        map = sform_of(bytes);
    else if (has_qform)
        map = qform_of(bytes, spacing_of(bytes, path), path);
    else
        map.linear() = spacing_of(bytes, path).asDiagonal();

    header.metadata["format"] = header.is_compressed ? "NIfTI-1, gzip" : "NIfTI-1, raw";
    header.metadata["orientation"] = has_sform ? "sform" : has_qform ? "qform" : "none";
    if (const std::string description = bytes.text(148, 80); !description.empty())
        header.metadata["descrip"] = description;
    const int length_unit = bytes.at<char>(123) & 7;
    if (length_unit >= 1 && length_unit <= 3) {
        constexpr std::array units = {"m", "mm", "um"};
        header.metadata["units"] = units[std::size_t(length_unit - 1)];
    }
    return header;
}

} // namespace isocast
