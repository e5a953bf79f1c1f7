// SPDX-License-Identifier: MPL-2.0
#include "quadrics/triangles.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>

namespace isocast {

void check(std::span<const TriangleMesh> meshes) {
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        const TriangleMesh& mesh = meshes[m];
        const auto vertex = std::ranges::find_if_not(mesh.vertices_world,
                                                     [](const Vec3d& v) { return v.allFinite(); });
        if (vertex != mesh.vertices_world.end())
            throw InputError(fmt::format("mesh {}: vertex {} is not finite", m,
                                         vertex - mesh.vertices_world.begin()));
        const auto vertex_count = static_cast<int>(mesh.vertices_world.size());
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            for (const int corner : mesh.triangles[i])
                if (corner < 0 || corner >= vertex_count)
                    throw InputError(
                        fmt::format("mesh {}: triangle {}: there is no vertex {}", m, i, corner));
        if (!mesh.normals_world.empty() && mesh.normals_world.size() != 3 * mesh.triangles.size())
            throw InputError(fmt::format("mesh {}: {} normals for {} corners", m,
                                         mesh.normals_world.size(), 3 * mesh.triangles.size()));
    }
}

std::array<Eigen::Vector3f, 3> corner_normals_of(const TriangleMesh& mesh, std::size_t i) {
    if (!mesh.normals_world.empty())
        return {mesh.normals_world[3 * i], mesh.normals_world[3 * i + 1],
                mesh.normals_world[3 * i + 2]};
    const Eigen::Vector3f normal =
        area_normal(triangle_of(mesh, i)).stableNormalized().cast<float>();
    return {normal, normal, normal};
}

} // namespace isocast
