// Normals of faces, edges and vertices that tell inside from outside at the closest feature.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/pseudonormals.h"

#include "distance_transform/mesh_topology.h"

#include <cmath>

namespace isocast {

namespace {

/// Unit normal; from the two shorter edges, whose cross product rounds least.
Vec3d face_normal(const std::array<Vec3d, 3>& corners) {
    const std::array<Vec3d, 3> edges = {corners[1] - corners[0], corners[2] - corners[1],
                                        corners[0] - corners[2]};
    int longest = 0;
    for (int k = 1; k < 3; ++k)
        if (edges[k].squaredNorm() > edges[longest].squaredNorm()) longest = k;
    return edges[(longest + 1) % 3].cross(edges[(longest + 2) % 3]).stableNormalized();
}

} // namespace

Pseudonormals::Pseudonormals(const Mesh& mesh) {
    MeshTopology topology = topology_of(mesh);
    of_fan_.assign(topology.fan_count, Vec3d::Zero());
    of_face_.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        std::array<Vec3d, 3> corners;
        for (int k = 0; k < 3; ++k) corners[k] = mesh.vertices_world[mesh.triangles[t][k]];
        of_face_.push_back(face_normal(corners));
        for (int k = 0; k < 3; ++k) {
            const Vec3d u = corners[(k + 1) % 3] - corners[k];
            const Vec3d v = corners[(k + 2) % 3] - corners[k];
            const double angle = std::atan2(u.cross(v).norm(), u.dot(v));
            of_fan_[topology.fan_of_corner[3 * t + k]] += angle * of_face_.back();
        }
    }
    of_edge_.assign(topology.edge_count(), Vec3d::Zero());
    edge_of_halfedge_.resize(topology.halfedges.size());
    for (std::size_t e = 0; e < topology.edge_count(); ++e) {
        for (const std::uint32_t halfedge : topology.edge(e)) {
            of_edge_[e] += of_face_[halfedge / 3];
            edge_of_halfedge_[halfedge] = static_cast<int>(e);
        }
    }
    fan_of_corner_ = std::move(topology.fan_of_corner);
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
