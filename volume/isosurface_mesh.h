// A triangle mesh of a field's isosurface: where it is, to within a voxel.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

namespace isocast {

struct IsosurfaceMesh {
    std::vector<Vec3d> vertices_world;
    std::vector<Eigen::Vector3i> triangles; // of no one winding
};

/// Of the samples at level 0, as if they were linear along the edges of the lattice: a vertex for
/// each cell that the surface passes, in the middle of where it crosses the cell's edges, and two
/// triangles for each of those edges.
///
/// source  Gibson 1998, "Constrained Elastic Surface Nets", without the relaxation
IsosurfaceMesh isosurface_mesh(const FieldSource& field, double iso_world);

} // namespace isocast
