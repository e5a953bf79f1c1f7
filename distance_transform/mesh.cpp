// A triangle mesh in double precision.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh.h"

#include <limits>

namespace isocast {

WorldBox bounding_box(const Mesh& mesh) {
    const double infinity = std::numeric_limits<double>::infinity();
    WorldBox box{Vec3d::Constant(infinity), Vec3d::Constant(-infinity)};
    for (const std::array<int, 3>& triangle : mesh.triangles) {
        for (const int vertex : triangle) {
            box.min = box.min.cwiseMin(mesh.vertices_world[vertex]);
            box.max = box.max.cwiseMax(mesh.vertices_world[vertex]);
        }
    }
    return box;
}

Vec3d face_normal(const Mesh& mesh, int triangle) {
    std::array<Vec3d, 3> edges;
    int longest = 0;
    for (int k = 0; k < 3; ++k) {
        edges[k] = mesh.vertices_world[mesh.triangles[triangle][(k + 1) % 3]] -
                   mesh.vertices_world[mesh.triangles[triangle][k]];
        if (edges[k].squaredNorm() > edges[longest].squaredNorm()) longest = k;
    }
    return edges[(longest + 1) % 3].cross(edges[(longest + 2) % 3]).stableNormalized();
}

} // namespace isocast
