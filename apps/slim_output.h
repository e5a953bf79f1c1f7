// Meshes and points that become SLIM surfaces, and what is said of these.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/checked_mesh.h"
#include "distance_transform/convert_points.h"
#include "volume/progress.h"

#include <filesystem>
#include <optional>
#include <string>

namespace isocast {

/// Writes the surface of a mesh or of points as pieces of quadrics, and reports it on stdout.
///
/// max_error  of the diagonal of the box; a thousandth if empty
/// throws     UsageError if it is not in (0, 0.1]; InputError as slim_of_points; InputError,
///            ResourceError as write_slim
void convert_to_slim(const std::string& input, const CheckedMesh& mesh,
                     const std::optional<double>& max_error, const std::filesystem::path& output,
                     bool is_json, const Progress& progress);

void convert_to_slim(const std::string& input, const CheckedPoints& points,
                     const std::optional<double>& max_error, const std::filesystem::path& output,
                     bool is_json, const Progress& progress);

/// On stdout, of a file.
/// throws  InputError as read_slim
void describe_slim(const std::string& path, bool is_json);

} // namespace isocast
