// Meshes simplified by CGAL's edge collapse, which is under the GPL: for benches and pictures alone.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"
#include "quadrics/triangles.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

namespace isocast {

using CollapsibleMesh = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;

/// Without the triangles that would make it no manifold.
CollapsibleMesh collapsible(const TriangleMesh& mesh);

/// Back again; of a mesh whose removed elements are collected, as collapse_edges() leaves it.
Mesh mesh_of(const CollapsibleMesh& mesh);

/// Edges go by Lindstrom and Turk's cost and placement until so many are left, or none can go.
void collapse_edges(CollapsibleMesh& mesh, std::size_t edges_left);

} // namespace isocast
