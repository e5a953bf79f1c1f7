// Points with normals, made ready for the meshless transform, and the report of their condition.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace isocast {

struct CheckedMesh;

struct PointCloud {
    std::vector<Vec3d> points_world;
    std::vector<Vec3d> normals; // outward, of any length; empty if there are none
};

/// A cloud ready for the transform, and what was found on the way.
struct CheckedPoints {
    PointCloud cloud; // distinct points, unit normals
    bool normals_given = false;
    /// Of each point: the edge of a square as large as the piece of surface that it stands for,
    /// from the nearest points that face its way.
    std::vector<double> spacing_world;
    double median_spacing_world = 0;
    /// One sentence each, for the user.
    std::vector<std::string> warnings;
};

/// Examines and cleans a cloud: no two points at nearly one position, normals of unit length,
/// estimated and oriented where any is missing.
///
/// neighbours  that normals and spacings are taken from, and that the transform will look at
/// throws      InputError if points are too few, not finite, or all on a line
CheckedPoints check(const PointCloud& cloud, int neighbours);

/// The vertices of a mesh with angle-weighted normals.
PointCloud vertices_of(const CheckedMesh& mesh);

/// True for a file name that read_cloud understands, by its extension.
bool is_cloud_file(const std::filesystem::path& path);
std::string cloud_file_extensions();

/// Reads points as they stand in the file: XYZ (x y z, or x y z nx ny nz, a line), PLY and OBJ with
/// normals if it has one for each vertex, and the vertices of other meshes. Where a mesh has
/// triangles but no normals they come from those.
/// throws  InputError that names the file, the line or element, and the cause
PointCloud read_cloud(const std::filesystem::path& path);

/// Parses XYZ text; '#' begins a comment.
/// throws  InputError that names the line and the cause
PointCloud parse_cloud(std::string_view bytes, std::string_view name);

} // namespace isocast
