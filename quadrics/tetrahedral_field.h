// Quadratic functions in the tetrahedra of a mesh, from a file, and their isosurfaces.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/tetrahedra.h"

#include <filesystem>

namespace isocast {

struct TetrahedralField {
    std::vector<Vec3d> vertices_world;
    std::vector<std::array<int, 4>> tetrahedra;
    /// Bernstein-Bézier coefficients of each: of the corners, then of tetrahedron_edges.
    std::vector<std::array<double, 10>> coefficients;
};

/// Reads a legacy VTK file in ASCII: an UNSTRUCTURED_GRID of cells of type 10 (four points: the
/// function is linear) and 24 (four points, then the middles of the edges 01 12 02 03 13 23: it is
/// quadratic), and the first SCALARS of its POINT_DATA, the function's values there.
/// throws  InputError that names the file, and what is wrong: truncated, other cells, a point of an
///         edge that is not its middle to 1e-6 of its length, …
TetrahedralField read_tetrahedra(const std::filesystem::path& path);

/// Where it is `iso`, with what is less inside.
TetrahedralMesh isosurface(const TetrahedralField& field, double iso);

} // namespace isocast
