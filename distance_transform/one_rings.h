// Vertices with the triangles around them in order, and how the surface bends at edges.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <cstdint>
#include <span>

namespace isocast {

/// How two triangles meet: Convex where the solid's dihedral angle is below 180 degrees. Flat edges
/// and boundaries are neither convex nor concave.
enum class Bend { Convex, Flat, Concave };

/// A vertex is Saddle if edges of both kinds meet there, Flat if all are flat.
enum class VertexKind { Convex, Concave, Saddle, Flat };

/// The neighbourhoods of a mesh. Half-edge 3 t + k runs from corner k of triangle t to the next;
/// it names that corner too. A vertex where several fans meet has one ring per fan.
struct OneRings {
    std::vector<int> twins; // the half-edge of the other triangle; -1 at a boundary
    /// Corners ring by ring, counter-clockwise seen from outside: triangle F_i = (c, x_i, x_i+1)
    /// of thesis figure 4.6 is that of corner i.
    std::vector<int> corners;
    std::vector<std::size_t> ring_begin;
    std::vector<Vec3d> face_normals; // unit
    std::vector<Bend> bends;         // per half-edge

    std::size_t count() const { return ring_begin.size() - 1; }
    std::span<const int> ring(std::size_t i) const {
        return std::span(corners).subspan(ring_begin[i], ring_begin[i + 1] - ring_begin[i]);
    }
    /// False at a vertex on a boundary.
    bool is_closed(std::size_t ring) const;
    VertexKind kind(std::size_t ring) const;
};

/// throws  InputError if an edge is not shared by two triangles of the same orientation, or one
OneRings one_rings(const Mesh& mesh);

/// The half-edge that ends where `halfedge` begins, in the same triangle.
constexpr int previous_halfedge(int halfedge) {
    return halfedge % 3 == 0 ? halfedge + 2 : halfedge - 1;
}

} // namespace isocast
