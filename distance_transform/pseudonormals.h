// Normals of faces, edges and vertices that tell inside from outside at the closest feature.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh_topology.h"
#include "distance_transform/point_triangle.h"

namespace isocast {

/// Angle-weighted pseudonormals: a point whose closest point of a closed oriented surface is q
/// lies outside iff (p - q) · n > 0, n being the normal of the feature on which q lies.
///
/// source  Bærentzen & Aanæs 2005; at a vertex where several fans meet, one normal per fan
class Pseudonormals {
public:
    /// topology  of `mesh`
    Pseudonormals(const Mesh& mesh, const MeshTopology& topology);
    explicit Pseudonormals(const Mesh& mesh) : Pseudonormals(mesh, topology_of(mesh)) {}
    /// Not normalised; direction matters only.
    const Vec3d& at(int triangle, Feature feature) const;

private:
    std::vector<Vec3d> of_face_;
    std::vector<Vec3d> of_edge_;
    std::vector<Vec3d> of_fan_;
    std::vector<int> edge_of_halfedge_;
    std::vector<int> fan_of_corner_;
};

} // namespace isocast
