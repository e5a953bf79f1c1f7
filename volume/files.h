// Field files. One .cpp per format; this header is all that the rest of the program sees of them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/progress.h"
#include "volume/sparse_field.h"

#include <filesystem>
#include <map>
#include <memory>
#include <string>

namespace isocast {

/// What a grid in a file says of itself, without its samples.
struct GridDescription {
    std::string name;
    std::string grid_class; // "level set", "fog volume", "unknown"
    std::string value_type; // "float", "half", "double", "vec3s", …
    Eigen::Affine3d world_from_index = Eigen::Affine3d::Identity();
    double background_world = 0;
    std::int64_t active_voxels = 0;
    IndexBox active_box;
    std::map<std::string, std::string> metadata;
};

/// True for a file name that read_field understands, by its extension.
bool is_field_file(const std::filesystem::path& path);
/// The extensions that read_field understands, for messages.
std::string field_file_extensions();

/// Reads a scalar field.
///
/// path       a .vdb file
/// grid_name  the grid to take; empty takes the first float or double grid, by name
/// throws     InputError that names the file, the cause and, where a grid is missing or of another
///            type, the grids that there are
std::unique_ptr<FieldSource> read_field(const std::filesystem::path& path,
                                        const std::string& grid_name = {});

/// All grids of a field file.
/// throws  InputError as read_field
std::vector<GridDescription> describe_field_file(const std::filesystem::path& path);

/// Writes `field` as an OpenVDB file with one float grid named "surface": GRID_LEVEL_SET for
/// signed fields (GRID_UNKNOWN for others), background = half width [world], tiles of the inside
/// set to -background, pruned. The file appears whole or not at all.
///
/// metadata  string metadata to store beside (creator, source, sign method, …)
/// throws    InputError if the folder does not exist, ResourceError if the disk is full
void write_vdb(const SparseField& field, const std::filesystem::path& path,
               const std::map<std::string, std::string>& metadata = {});

} // namespace isocast
