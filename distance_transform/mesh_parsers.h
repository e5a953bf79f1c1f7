// One parser per mesh format, from bytes in memory; read_mesh chooses by the file's extension.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <span>
#include <string_view>

namespace isocast {

/// Each parser takes the bytes of a whole file and the name that messages give it, and returns the
/// mesh as it stands there.
/// throws  InputError that names the line or element and the cause
Mesh parse_obj(std::string_view bytes, std::string_view name);
Mesh parse_ply(std::string_view bytes, std::string_view name);
Mesh parse_stl(std::string_view bytes, std::string_view name);
Mesh parse_off(std::string_view bytes, std::string_view name);

/// Appends `polygon` (three corners or more) cut into a fan about its first corner.
void append_fan(Mesh& mesh, std::span<const int> polygon);

} // namespace isocast
