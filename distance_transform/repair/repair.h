// Closed, oriented meshes from soups, by CGAL: programs that link this are under the GPL.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <string>

namespace isocast {

/// What repair() did, by count.
struct RepairReport {
    int removed_triangles = 0; // degenerate or duplicate
    int added_vertices = 0;    // where triangles that met in no manifold way were parted
    int holes = 0;             // border cycles
    int filled_holes = 0;
    int filling_triangles = 0;
    bool is_closed = false; // and then oriented to bound a volume
    /// One line, e.g. "5 of 5 holes filled with 213 triangles; closed".
    std::string summary() const;
};

struct RepairedMesh {
    Mesh mesh;
    RepairReport report;
};

/// A triangle soup made manifold and oriented, its holes filled; if that closes it, turned so that
/// it bounds a volume.
///
/// Vertices stay where they are. Holes are filled with triangles of least dihedral angles and area
/// between their border's vertices alone, unless no such triangulation is manifold. Of nested
/// shells every second becomes a cavity, whichever way it was turned. What intersects itself still
/// does.
/// throws  InputError if no triangle remains
/// source  CGAL 5.5, Polygon Mesh Processing; holes after Liepa 2003, as its manual says
RepairedMesh repair(const Mesh& mesh);

} // namespace isocast
