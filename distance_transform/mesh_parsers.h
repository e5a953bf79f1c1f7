// One parser per mesh format, from bytes in memory; read_mesh chooses by the file's extension.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace isocast {

/// Each parser takes the bytes of a whole file and the name that messages give it, and returns the
/// mesh as it stands there.
/// throws  InputError that names the line or element and the cause
Mesh parse_obj(std::string_view bytes, std::string_view name);
Mesh parse_ply(std::string_view bytes, std::string_view name);
Mesh parse_stl(std::string_view bytes, std::string_view name);
Mesh parse_off(std::string_view bytes, std::string_view name);

/// The same for points: no faces are needed, and normals of the vertices are told, if any
/// (OBJ: all `vn`, which may be for corners of faces instead).
///
/// corner_counts  is told how many corners each face has, if it is not null
Mesh parse_obj(std::string_view bytes, std::string_view name, std::vector<Vec3d>* vertex_normals,
               std::vector<int>* corner_counts = nullptr);
Mesh parse_ply(std::string_view bytes, std::string_view name, std::vector<Vec3d>* vertex_normals,
               std::vector<int>* corner_counts = nullptr);

/// The bytes of a file.
/// throws  InputError that names it and the cause: missing, a directory, empty, …
std::string read_whole(const std::filesystem::path& path);

/// Appends `polygon` (three corners or more) cut into a fan about its first corner.
void append_fan(Mesh& mesh, std::span<const int> polygon);

} // namespace isocast
