// A mesh made ready for the transform, and the report of its condition.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh_topology.h"

#include <string>

namespace isocast {

/// What is true of a mesh, by count. Vertices at exactly the same position are one vertex here,
/// so that unindexed soups get their topology.
struct MeshVerdict {
    int vertices = 0;              // as given
    int triangles = 0;             // as given
    int unreferenced_vertices = 0; // used by no triangle
    int duplicate_vertices = 0;    // at exactly the position of another one in use
    int degenerate_triangles = 0;  // two equal corners, or area exactly 0 in double
    int duplicate_triangles = 0;   // same three vertices as an earlier one, in either orientation
    int boundary_edges = 0;        // used by one triangle
    int boundary_loops = 0;        // holes: connected components of the boundary edges
    int non_manifold_edges = 0;    // used by three triangles or more
    int flipped_edges = 0;         // used twice in the same direction, as given
    int turned_triangles = 0;      // against their neighbours, hence turned round
    bool is_orientable = true;     // false for a Möbius strip: no turns suit all edges
    int non_manifold_vertices = 0; // triangles around them form more than one fan
    int shells = 0;                // components connected through edges
    double volume_world = 0;       // signed; meaningful if closed and oriented
    bool reversed = false;         // was closed with negative volume; orientation was turned

    bool is_closed() const { return boundary_edges == 0 && non_manifold_edges == 0; }
    /// Of the mesh as cleaned.
    bool is_oriented() const { return flipped_edges == 0 || turned_triangles > 0; }
    bool is_manifold() const { return non_manifold_edges == 0 && non_manifold_vertices == 0; }
    /// One line, e.g. "closed, oriented, manifold" or "open: 223 boundary edges in 5 holes".
    std::string summary() const;
};

/// A mesh ready for the transform, and what was found on the way.
struct CheckedMesh {
    /// Vertices merged by position, degenerate and duplicate triangles removed, unused vertices
    /// dropped; triangles turned that disagreed with their neighbours, and all of them if the mesh
    /// was inside out.
    Mesh mesh;
    MeshTopology topology; // of `mesh`
    MeshVerdict verdict;
    /// One sentence each, for the user.
    std::vector<std::string> warnings;
};

/// Examines and cleans a mesh.
/// throws  InputError if no triangle remains
CheckedMesh check(const Mesh& mesh);

} // namespace isocast
