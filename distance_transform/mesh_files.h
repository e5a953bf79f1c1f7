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

/// A mesh with its polygons, whose fans the triangles are, in order.
struct PolygonMesh {
    Mesh mesh;
    std::vector<int> corner_counts; // of each face
};
/// throws  InputError as read_mesh(), and for formats other than .obj and .ply
PolygonMesh read_polygons(const std::filesystem::path& path);

/// Writes a mesh; positions with as many digits as give the double back (doubles in binary PLY).
///
/// Format by extension: .obj, .ply, .off, and .stl, which is written as text since binary STL holds
/// float32, and which gives each triangle its own three vertices back. The file appears whole or
/// not at all.
/// throws  InputError for an unknown extension or folder, ResourceError if writing fails
void write_mesh(const Mesh& mesh, const std::filesystem::path& path);

} // namespace isocast
