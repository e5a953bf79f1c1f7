// Normals of faces, edges and vertices that tell inside from outside at the closest feature.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/pseudonormals.h"

#include <tbb/parallel_for.h>

namespace isocast {

Pseudonormals::Pseudonormals(const Mesh& mesh, const MeshTopology& topology)
    : of_face_(mesh.triangles.size()), of_edge_(topology.edge_count(), Vec3d::Zero()),
      of_fan_(topology.fan_count, Vec3d::Zero()), edge_of_halfedge_(topology.halfedges.size()),
      fan_of_corner_(topology.fan_of_corner) {
    std::vector<std::array<double, 3>> angles(mesh.triangles.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, angles.size(), 1024), [&](auto& range) {
        for (std::size_t t = range.begin(); t < range.end(); ++t) {
            std::array<Vec3d, 3> corners;
            for (int k = 0; k < 3; ++k) corners[k] = mesh.vertices_world[mesh.triangles[t][k]];
            of_face_[t] = face_normal(mesh, static_cast<int>(t));
            for (int k = 0; k < 3; ++k) {
                const Vec3d u = corners[(k + 1) % 3] - corners[k];
                const Vec3d v = corners[(k + 2) % 3] - corners[k];
                angles[t][k] = angle_between(u, v);
            }
        }
    });
    for (std::size_t c = 0; c < fan_of_corner_.size(); ++c)
        of_fan_[fan_of_corner_[c]] += angles[c / 3][c % 3] * of_face_[c / 3];
    for (std::size_t e = 0; e < topology.edge_count(); ++e) {
        for (const std::uint32_t halfedge : topology.edge(e)) {
            of_edge_[e] += of_face_[halfedge / 3];
            edge_of_halfedge_[halfedge] = static_cast<int>(e);
        }
    }
}

const Vec3d& Pseudonormals::at(int triangle, Feature feature) const {
    const std::size_t first = 3 * static_cast<std::size_t>(triangle);
    switch (feature) {
    case Feature::Face:
        break;
    case Feature::Edge01:
        return of_edge_[edge_of_halfedge_[first]];
    case Feature::Edge12:
        return of_edge_[edge_of_halfedge_[first + 1]];
    case Feature::Edge20:
        return of_edge_[edge_of_halfedge_[first + 2]];
    case Feature::Vertex0:
        return of_fan_[fan_of_corner_[first]];
    case Feature::Vertex1:
        return of_fan_[fan_of_corner_[first + 1]];
    case Feature::Vertex2:
        return of_fan_[fan_of_corner_[first + 2]];
    }
    return of_face_[triangle];
}

} // namespace isocast
