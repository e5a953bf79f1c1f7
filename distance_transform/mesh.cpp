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

} // namespace isocast
