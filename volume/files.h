// Field files. One .cpp per format; this header is all that the rest of the program sees of them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/available_memory.h"
#include "volume/progress.h"
#include "volume/sparse_field.h"

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

namespace isocast {

/// What a grid in a file says of itself, without its samples.
struct GridDescription {
    std::string name;
    std::string grid_class; // "level set", "fog volume", "unknown"; "dense" in other files
    std::string value_type; // "float", "half", "double", "vec3s", …; "uint8", "int16", …
    Eigen::Affine3d world_from_index = Eigen::Affine3d::Identity();
    bool is_affine = true; // false for a frustum, whose map cannot be given, nor its samples read
    double background_world = 0;
    std::int64_t active_voxels = 0;
    IndexBox active_box;
    std::map<std::string, std::string> metadata;
};

/// The extension of a file name, with its dot; capitals of ASCII as small letters.
std::string lower_case_extension(const std::filesystem::path& path);

/// True for the name of an octree file, .hoct.
bool is_octree_file(const std::filesystem::path& path);
/// True for a file name that read_field understands, by its extension.
bool is_field_file(const std::filesystem::path& path);
/// The extensions that read_field understands, for messages.
std::string field_file_extensions();

/// Reads a scalar field.
///
/// path       a .vdb file; or an octree, .hoct, on the lattice of its finest cells at the surface
///            (OctreeField; fields_of_octree tells of all); or a dense volume: .nrrd or .nhdr, .mhd
///            or .mha, .nii or .nii.gz. Their samples keep their type; uncompressed ones are mapped
///            and read when they are asked for, so that a file may be larger than memory.
///            Headerless samples need an .mhd.
/// grid_name  the grid to take; empty takes the first float or double grid, by name. Only .vdb
///            files have names.
/// memory_bytes  what the samples of .vdb files and of compressed volumes may take: beyond it they
///            lie in a scratch file (fresh_memory.h), are the same to the last bit, and are read
///            from there when they are asked for
/// throws     InputError that names the file, the cause and, where a grid is missing or of another
///            type, the grids that there are. Samples that are NaN throw when they are asked for.
///            ResourceError if there is no room, or none for the scratch file
std::unique_ptr<FieldSource> read_field(const std::filesystem::path& path,
                                        const std::string& grid_name = {},
                                        double memory_bytes = default_field_bytes());

/// All grids of a field file.
/// throws  InputError as read_field
std::vector<GridDescription> describe_field_file(const std::filesystem::path& path);

/// What else is known at each active sample of a field: by the number of the block in
/// field.blocks(), and the sample in it. Either may be empty.
struct ClosestGrids {
    std::function<Eigen::Vector3f(std::size_t block, int sample)> offset_world;
    std::function<std::int32_t(std::size_t block, int sample)> feature;
};

/// Writes `field` as an OpenVDB file with one float grid named "surface": GRID_LEVEL_SET for
/// signed fields (GRID_UNKNOWN for others), background = half width [world], tiles of the inside
/// set to -background, pruned. The file appears whole or not at all.
///
/// metadata  string metadata to store beside (creator, source, sign method, …)
/// closest   becomes the grids "closest" (vectors) and "feature" (integers)
/// throws    InputError if the folder does not exist, ResourceError if the disk is full
void write_vdb(const SparseField& field, const std::filesystem::path& path,
               const std::map<std::string, std::string>& metadata = {},
               const ClosestGrids& closest = {});

/// Writes one field at several resolutions, as the grids surface_level_0, surface_level_1, … (named
/// as those of OpenVDB's MultiResGrid are), each as write_vdb does.
void write_vdb_levels(const std::function<SparseField(int level)>& field_of, int level_count,
                      const std::filesystem::path& path,
                      const std::map<std::string, std::string>& metadata = {});

// Dense files: every sample of the field's extent, as float32, little endian, x fastest, cut from
// the field slab by slab so that no dense copy is ever in memory.

/// True for a file name that write_dense understands, by its extension.
bool is_dense_file(const std::filesystem::path& path);
/// The extensions that write_dense understands, for messages.
std::string dense_file_extensions();

/// Writes the field's extent in the format of the extension: .nrrd, .mhd (and .raw beside it),
/// .vti. The file appears whole or not at all; of the pair the .raw first, so that whoever sees a
/// new .mhd sees its samples.
///
/// throws  InputError for an unknown extension, a folder that does not exist, an empty extent, or a
///         sheared grid in a format that has no place for one (.mhd, .vti); ResourceError if the
///         disk has too little room, before anything is written, or fails
void write_dense(const FieldSource& field, const std::filesystem::path& path,
                 const Progress& progress = {});

/// NRRD with attached header: `space directions` hold any affine map.
/// source  teem.sourceforge.net/nrrd/format.html, NRRD0004; teem's own program reads it (a test)
void write_nrrd(const FieldSource& field, const std::filesystem::path& path,
                const Progress& progress = {});

/// MetaImage: header .mhd, samples in a .raw of the same name. Rotated grids, no sheared ones.
/// source  ITK's itkMetaImageIO.cxx: rows of TransformMatrix are the directions of the axes
void write_mhd(const FieldSource& field, const std::filesystem::path& path,
               const Progress& progress = {});

/// VTK ImageData, raw appended samples with 64-bit sizes. The extent keeps the field's indices.
/// Rotated grids (VTK 9 and later read `Direction`), no sheared ones.
/// source  VTK's vtkXMLImageDataReader.cxx
void write_vti(const FieldSource& field, const std::filesystem::path& path,
               const Progress& progress = {});

} // namespace isocast
