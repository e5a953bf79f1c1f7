// Reading and writing triangle meshes: OBJ, PLY (ascii, binary), STL (ascii, binary), OFF.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <filesystem>

namespace isocast {

/// True for a file name that read_mesh understands, by its extension.
bool is_mesh_file(const std::filesystem::path& path);
std::string mesh_file_extensions();

/// Reads a mesh as it stands in the file; positions in double, polygons cut into fans.
/// throws  InputError that names the file, the line or element, and the cause: missing, truncated,
///         no triangles, a coordinate that is not finite, an index out of range, …
Mesh read_mesh(const std::filesystem::path& path);

/// Writes a mesh; positions with 17 digits (doubles in binary PLY), so that reading gives it back.
/// Format by extension: .obj, .ply, .off, .stl. The file appears whole or not at all.
void write_mesh(const Mesh& mesh, const std::filesystem::path& path);

} // namespace isocast
