// What the words of a command line name: meshes, fields, molecules and outputs.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/checked_mesh.h"
#include "volume/available_memory.h"
#include "volume/field_source.h"

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace isocast {

/// A command line that cannot be right, whatever its files hold.
struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A mesh, a field, a molecule or a SLIM surface, by file or by built-in name. Nothing has been
/// read yet.
struct Input {
    enum class Kind { MeshFile, SampleMesh, FieldFile, BuiltinField, MoleculeFile, SlimFile };
    Kind kind = Kind::MeshFile;
    std::string text = {};     // as the user wrote it
    std::string name = {};     // path or built-in name
    std::string grid = {};     // of a field file; empty for its first
    int samples_per_axis = 64; // of a built-in field

    bool is_mesh() const { return kind == Kind::MeshFile || kind == Kind::SampleMesh; }
    bool is_field() const { return kind == Kind::FieldFile || kind == Kind::BuiltinField; }
    bool is_slim() const { return kind == Kind::SlimFile; }
    /// "a mesh", "a field", "a molecule" or "a SLIM surface".
    const char* what() const;
};

/// Understands `mesh:NAME`, `field:NAME@N`, a mesh file, a field file, `FILE:GRID`
/// a molecule file and a SLIM file.
/// throws  InputError if it is none of these or the file does not exist
Input input_from(const std::string& text);

/// throws  InputError that names the input and the cause
CheckedMesh read_checked_mesh(const Input& input);
/// throws        InputError that names the input and the cause
/// memory_bytes  what the samples of a file may take before they go to a scratch file
std::unique_ptr<FieldSource> read_field(const Input& input,
                                        double memory_bytes = default_field_bytes());

/// Finds out before the long work whether `path` can be written.
/// extensions  those allowed, with their dots
/// throws      UsageError for another extension; InputError if the folder does not exist or cannot
///             be written to
void check_output(const std::filesystem::path& path, const std::vector<std::string>& extensions);

/// Where a user's own settings lie: $XDG_CONFIG_HOME/isocast, or that in ~/.config; empty for a
/// user who has neither.
std::filesystem::path config_folder();

/// throws  std::runtime_error if none of the folders exists
std::filesystem::path first_folder_of(const std::vector<std::filesystem::path>& folders);

/// A finite number, all of `text`.
/// throws  UsageError
double number_from(std::string_view text);
/// throws  UsageError
int integer_from(std::string_view text);
/// A number of bytes, e.g. 8G or 500M (powers of 1024).
/// throws  UsageError
double bytes_from(std::string_view text);

} // namespace isocast
