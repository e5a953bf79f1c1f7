// Which reader or writer a field file's extension calls for.
// SPDX-License-Identifier: MPL-2.0
#include "volume/files.h"

#include "volume/errors.h"
#include "volume/octree_field.h"
#include "volume/octree_file.h"
#include "volume/vdb_file.h"
#include "volume/volume_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace isocast {

namespace {

struct DenseFormat {
    std::string_view extension;
    void (*write)(const FieldSource&, const std::filesystem::path&, const Progress&);
};

constexpr std::array dense_formats = {DenseFormat{".nrrd", write_nrrd},
                                      DenseFormat{".mhd", write_mhd},
                                      DenseFormat{".vti", write_vti}};

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

/// The level of the coarsest leaf, with the counts of all, as text.
GridDescription describe_octree(const std::filesystem::path& path) {
    const OctreeFile file = read_octree(path);
    const HashedOctree& tree = file.tree;
    std::vector<std::size_t> leaves(static_cast<std::size_t>(tree.depth()) + 1);
    tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
        if (is_leaf) ++leaves[static_cast<std::size_t>(cell.level)];
    });
    GridDescription grid{.name = "octree",
                         .grid_class = "octree",
                         .value_type = "float",
                         .world_from_index = file.space.world_from_index,
                         .active_voxels = static_cast<std::int64_t>(tree.node_count()),
                         .active_box = {Index3::Zero(), Index3::Constant(tree.root().size() + 1)},
                         .metadata = file.provenance};
    grid.metadata["interpolation"] = tree.filter() == OctreeFilter::Linear ? "linear" : "cubic";
    grid.metadata["cells"] = fmt::format("{}", tree.cell_count());
    std::string counts;
    for (std::size_t level = 0; level < leaves.size(); ++level)
        if (leaves[level] > 0)
            counts += fmt::format("{}{} of size {}", counts.empty() ? "" : ", ", leaves[level],
                                  std::size_t{1} << level);
    grid.metadata["leaves"] = counts;
    return grid;
}

void require_field_file(const std::filesystem::path& path) {
    if (is_field_file(path)) return;
    throw InputError(fmt::format("{}: not a field file by its extension (known: {})", path.string(),
                                 field_file_extensions()));
}

} // namespace

std::string lower_case_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return extension;
}

bool is_octree_file(const std::filesystem::path& path) {
    return lower_case_extension(path) == ".hoct";
}

bool is_field_file(const std::filesystem::path& path) {
    return lower_case_extension(path) == ".vdb" || is_octree_file(path) ||
           volume_format_of(path) != nullptr;
}

std::string field_file_extensions() {
    std::string all = ".vdb .hoct";
    for (const VolumeFormat& format : volume_formats) all += fmt::format(" {}", format.extension);
    return all;
}

std::unique_ptr<FieldSource> read_field(const std::filesystem::path& path,
                                        const std::string& grid_name, double memory_bytes) {
    require_field_file(path);
    const VolumeFormat* const format = volume_format_of(path);
    if (format == nullptr && !is_octree_file(path))
        return std::make_unique<SparseField>(read_vdb(path, grid_name, memory_bytes));
    if (!grid_name.empty() && !(is_octree_file(path) && grid_name == "octree"))
        cannot_read(path,
                    fmt::format("no grid named '{}': only .vdb files hold named grids", grid_name));
    if (format == nullptr) {
        OctreeFile file = read_octree(path);
        const auto tree = std::make_shared<const HashedOctree>(std::move(file.tree));
        constexpr std::size_t any = std::numeric_limits<std::size_t>::max();
        return std::make_unique<OctreeField>(*fields_of_octree(tree, file.space, 0, any).front());
    }
    return open_volume(format->header(path), path, memory_bytes);
}

std::vector<GridDescription> describe_field_file(const std::filesystem::path& path) {
    require_field_file(path);
    if (is_octree_file(path)) return {describe_octree(path)};
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
