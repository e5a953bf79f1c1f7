// SPDX-License-Identifier: MPL-2.0
#include "quadrics/triangles.h"

#include "quadrics/indexed_mesh.h"

namespace isocast {

void check(std::span<const TriangleMesh> meshes) {
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        const TriangleMesh& mesh = meshes[m];
        check_elements(fmt::format("mesh {}", m), "triangle ", mesh.vertices_world, mesh.triangles);
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
