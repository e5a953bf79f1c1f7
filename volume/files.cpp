// Which reader or writer a field file's extension calls for.
// SPDX-License-Identifier: MPL-2.0
#include "volume/files.h"

#include "volume/errors.h"
#include "volume/vdb_file.h"
#include "volume/volume_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace isocast {

namespace {

struct DenseFormat {
    std::string_view extension;
    void (*write)(const FieldSource&, const std::filesystem::path&, const Progress&);
};

constexpr std::array dense_formats = {DenseFormat{".nrrd", write_nrrd},
                                      DenseFormat{".mhd", write_mhd},
                                      DenseFormat{".vti", write_vti}};

std::string lower_case_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return std::tolower(c); });
    return extension;
}

struct VolumeFormat {
    std::string_view extension;
    VolumeHeader (*header)(const std::filesystem::path&);
};

/// Those that are read as dense volumes.
constexpr std::array volume_formats = {
    VolumeFormat{".nrrd", nrrd_header}, VolumeFormat{".nhdr", nrrd_header},
    VolumeFormat{".mhd", mhd_header},   VolumeFormat{".mha", mhd_header},
    VolumeFormat{".nii", nifti_header}, VolumeFormat{".nii.gz", nifti_header}};

const VolumeFormat* volume_format_of(const std::filesystem::path& path) {
    std::string extension = lower_case_extension(path);
    if (extension == ".gz") extension = lower_case_extension(path.stem()) + extension;
    const auto found = std::ranges::find(volume_formats, extension, &VolumeFormat::extension);
    return found == volume_formats.end() ? nullptr : found;
}

const DenseFormat* dense_format_of(const std::filesystem::path& path) {
    const std::string extension = lower_case_extension(path);
    const auto found = std::ranges::find(dense_formats, extension, &DenseFormat::extension);
    return found == dense_formats.end() ? nullptr : found;
}

void require_field_file(const std::filesystem::path& path) {
    if (is_field_file(path)) return;
    throw InputError(fmt::format("{}: not a field file by its extension (known: {})", path.string(),
                                 field_file_extensions()));
}

} // namespace

bool is_field_file(const std::filesystem::path& path) {
    return lower_case_extension(path) == ".vdb" || volume_format_of(path) != nullptr;
}

std::string field_file_extensions() {
    std::string all = ".vdb";
    for (const VolumeFormat& format : volume_formats) all += fmt::format(" {}", format.extension);
    return all;
}

std::unique_ptr<FieldSource> read_field(const std::filesystem::path& path,
                                        const std::string& grid_name, double memory_bytes) {
    require_field_file(path);
    const VolumeFormat* const format = volume_format_of(path);
    if (format == nullptr)
        return std::make_unique<SparseField>(read_vdb(path, grid_name, memory_bytes));
    if (!grid_name.empty())
        cannot_read(path,
                    fmt::format("no grid named '{}': only .vdb files hold named grids", grid_name));
    return open_volume(format->header(path), path, memory_bytes);
}

std::vector<GridDescription> describe_field_file(const std::filesystem::path& path) {
    require_field_file(path);
    const VolumeFormat* const format = volume_format_of(path);
    if (format == nullptr) return describe_vdb(path);
    return {describe_volume(format->header(path), path)};
}

bool is_dense_file(const std::filesystem::path& path) {
    return dense_format_of(path) != nullptr;
}

std::string dense_file_extensions() {
    std::string all;
    for (const DenseFormat& format : dense_formats)
        all += fmt::format("{}{}", all.empty() ? "" : ", ", format.extension);
    return all;
}

void write_dense(const FieldSource& field, const std::filesystem::path& path,
                 const Progress& progress) {
    const DenseFormat* const format = dense_format_of(path);
    if (format == nullptr)
        throw InputError(fmt::format("{}: not a dense file by its extension (known: {})",
                                     path.string(), dense_file_extensions()));
    format->write(field, path, progress);
}

} // namespace isocast
