// A triangle mesh in double precision.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cmath>
#include <limits>

namespace isocast {

WorldBox bounding_box(const Mesh& mesh) {
    const double infinity = std::numeric_limits<double>::infinity();
    using Range = tbb::blocked_range<std::size_t>;
    return tbb::parallel_reduce(
        Range(0, mesh.triangles.size(), 4096),
        WorldBox{Vec3d::Constant(infinity), Vec3d::Constant(-infinity)},
        [&](const Range& range, WorldBox box) {
            for (std::size_t t = range.begin(); t < range.end(); ++t) {
                for (const int vertex : mesh.triangles[t]) {
                    box.min = box.min.cwiseMin(mesh.vertices_world[vertex]);
                    box.max = box.max.cwiseMax(mesh.vertices_world[vertex]);
                }
            }
            return box;
        },
        [](const WorldBox& a, const WorldBox& b) {
            return WorldBox{a.min.cwiseMin(b.min), a.max.cwiseMax(b.max)};
        });
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

double angle_between(const Vec3d& a, const Vec3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

} // namespace isocast
