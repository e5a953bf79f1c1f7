// Reads points: XYZ text, and the vertices of mesh files with or without faces.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/checked_mesh.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/mesh_parsers.h"
#include "distance_transform/point_cloud.h"
#include "distance_transform/text_scanner.h"
#include "volume/errors.h"
#include "volume/files.h"

#include <fmt/format.h>

namespace isocast {

bool is_cloud_file(const std::filesystem::path& path) {
    return lower_case_extension(path) == ".xyz" || is_mesh_file(path);
}

std::string cloud_file_extensions() {
    return ".xyz, " + mesh_file_extensions();
}

PointCloud parse_cloud(std::string_view bytes, std::string_view name) {
    static constexpr std::array<std::string_view, 6> whats = {"x", "y", "z", "nx", "ny", "nz"};
    TextScanner scanner(bytes, name, {.hash_comments = true});
    PointCloud cloud;
    std::size_t per_line = 0; // 3 or 6, as the first line has it
    for (; !scanner.is_at_end(); scanner.next_line()) {
        std::array<double, 6> numbers{};
        TextScanner ahead = scanner;
        std::size_t count = 0;
        while (!ahead.token_on_line().empty()) ++count;
        if (count == 0) continue;
        if (count != 3 && count != 6)
            scanner.fail(fmt::format("{} numbers instead of x y z or x y z nx ny nz", count));
        if (per_line == 0) per_line = count;
        if (count != per_line)
            scanner.fail(fmt::format("{} numbers where the first line has {}", count, per_line));
        for (std::size_t k = 0; k < count; ++k) numbers[k] = scanner.number_on_line(whats[k]);
        cloud.points_world.emplace_back(numbers[0], numbers[1], numbers[2]);
        if (count == 6) cloud.normals.emplace_back(numbers[3], numbers[4], numbers[5]);
    }
    return cloud;
}

PointCloud read_cloud(const std::filesystem::path& path) {
    const std::string extension = lower_case_extension(path);
    if (!is_cloud_file(path))
        throw InputError(fmt::format("{}: unknown format '{}' of points (known: {})", path.string(),
                                     extension, cloud_file_extensions()));
    PointCloud cloud;
    if (extension == ".xyz") {
        cloud = parse_cloud(read_whole(path), path.string());
    } else if (extension == ".obj" || extension == ".ply") {
        std::vector<Vec3d> normals;
        const std::string bytes = read_whole(path);
        const Mesh mesh = extension == ".obj" ? parse_obj(bytes, path.string(), &normals)
                                              : parse_ply(bytes, path.string(), &normals);
        // The `vn` of an OBJ with faces go with corners.
        const bool has_normals = normals.size() == mesh.vertices_world.size() &&
                                 (extension == ".ply" || mesh.triangles.empty());
        if (!has_normals && !mesh.triangles.empty()) return vertices_of(check(mesh));
        cloud.points_world = mesh.vertices_world;
        if (has_normals) cloud.normals = std::move(normals);
    } else {
        return vertices_of(check(read_mesh(path)));
    }
    if (cloud.points_world.empty()) throw InputError(fmt::format("{}: no points", path.string()));
    return cloud;
}

} // namespace isocast
