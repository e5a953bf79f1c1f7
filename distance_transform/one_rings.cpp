// Vertices with the triangles around them in order, by walking from twin to twin.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/one_rings.h"

#include "distance_transform/mesh_topology.h"
#include "volume/errors.h"

#include <fmt/format.h>

namespace isocast {

namespace {

// Sine of the angle between two normals below which rounding decides its sign: a thousand roundings
// of a vertex that is a thousand edge lengths from the origin.
constexpr double flat_sine = 1e-10;

std::vector<int> twins_of(const Mesh& mesh) {
    const MeshTopology topology = topology_of(mesh);
    std::vector<int> twins(topology.halfedges.size(), -1);
    for (std::size_t e = 0; e < topology.edge_count(); ++e) {
        const auto halfedges = topology.edge(e);
        if (halfedges.size() == 1) continue;
        if (halfedges.size() > 2 ||
            halfedge_from(mesh, halfedges[0]) == halfedge_from(mesh, halfedges[1]))
            throw InputError(fmt::format(
                "the edge between vertices {} and {} is not shared by two triangles of the same "
                "orientation, as the thesis's polyhedra need",
                halfedge_from(mesh, halfedges[0]), halfedge_to(mesh, halfedges[0])));
        twins[halfedges[0]] = static_cast<int>(halfedges[1]);
        twins[halfedges[1]] = static_cast<int>(halfedges[0]);
    }
    return twins;
}

Bend bend_at(const Mesh& mesh, const OneRings& rings, int halfedge) {
    const int twin = rings.twins[halfedge];
    if (twin < 0) return Bend::Flat;
    const auto h = static_cast<std::uint32_t>(halfedge);
    const Vec3d along =
        (mesh.vertices_world[halfedge_to(mesh, h)] - mesh.vertices_world[halfedge_from(mesh, h)])
            .stableNormalized();
    const double sine =
        along.dot(rings.face_normals[halfedge / 3].cross(rings.face_normals[twin / 3]));
    return sine > flat_sine ? Bend::Convex : sine < -flat_sine ? Bend::Concave : Bend::Flat;
}

} // namespace

bool OneRings::is_closed(std::size_t i) const {
    return twins[ring(i).front()] >= 0;
}

VertexKind OneRings::kind(std::size_t i) const {
    bool has_convex = false;
    bool has_concave = false;
    for (const int corner : ring(i)) {
        has_convex |= bends[corner] == Bend::Convex;
        has_concave |= bends[corner] == Bend::Concave;
    }
    if (has_convex && has_concave) return VertexKind::Saddle;
    return has_convex ? VertexKind::Convex : has_concave ? VertexKind::Concave : VertexKind::Flat;
}

OneRings one_rings(const Mesh& mesh) {
    OneRings rings;
    rings.twins = twins_of(mesh);
    const int corner_count = static_cast<int>(rings.twins.size());
    for (int t = 0; t < corner_count / 3; ++t) rings.face_normals.push_back(face_normal(mesh, t));
    for (int h = 0; h < corner_count; ++h) rings.bends.push_back(bend_at(mesh, rings, h));

    std::vector<bool> is_seen(corner_count, false);
    const auto walk_from = [&](int first) {
        rings.ring_begin.push_back(rings.corners.size());
        int corner = first;
        do {
            is_seen[corner] = true;
            rings.corners.push_back(corner);
            corner = rings.twins[previous_halfedge(corner)];
        } while (corner >= 0 && corner != first);
    };
    // Fans at a boundary first: they are walked from their first triangle to their last.
    for (int corner = 0; corner < corner_count; ++corner)
        if (rings.twins[corner] < 0) walk_from(corner);
    for (int corner = 0; corner < corner_count; ++corner)
        if (!is_seen[corner]) walk_from(corner);
    rings.ring_begin.push_back(rings.corners.size());
    return rings;
}

} // namespace isocast
