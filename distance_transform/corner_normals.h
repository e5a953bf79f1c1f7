// Normals at the corners of triangles, by which a mesh is shaded as the smooth surface it stands
// for.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh_topology.h"

namespace isocast {

/// Of each corner, three a triangle: the mean of the normals of the triangles around its vertex
/// that it connects to through edges that bend by less than the crease, weighted by their angles
/// there. Edges of one triangle, of more than two, and of two that are turned against each other
/// are creases.
///
/// topology  of `mesh`
/// source    weights as Pseudonormals has them
std::vector<Eigen::Vector3f> corner_normals(const Mesh& mesh, const MeshTopology& topology,
                                            double crease_degrees);

} // namespace isocast
