// SPDX-License-Identifier: MPL-2.0
#include "slim/edge_collapse.h"

#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

namespace isocast {

CollapsibleMesh collapsible(const TriangleMesh& mesh) {
    CollapsibleMesh out;
    for (const Vec3d& p : mesh.vertices_world) out.add_vertex({p.x(), p.y(), p.z()});
    for (const auto& [a, b, c] : mesh.triangles) {
        const auto vertex = [](int i) {
            return CollapsibleMesh::Vertex_index(static_cast<CollapsibleMesh::size_type>(i));
        };
        out.add_face(vertex(a), vertex(b), vertex(c));
    }
    return out;
}

Mesh mesh_of(const CollapsibleMesh& mesh) {
    Mesh out;
    for (const auto v : mesh.vertices()) {
        const auto& p = mesh.point(v);
        out.vertices_world.emplace_back(p.x(), p.y(), p.z());
    }
    for (const auto face : mesh.faces()) {
        std::size_t k = 0;
        auto& corners = out.triangles.emplace_back();
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(face)))
            corners[k++] = static_cast<int>(v);
    }
    return out;
}

void collapse_edges(CollapsibleMesh& mesh, std::size_t edges_left) {
    namespace sms = CGAL::Surface_mesh_simplification;
    sms::edge_collapse(mesh, sms::Count_stop_predicate<CollapsibleMesh>(edges_left),
                       CGAL::parameters::get_cost(sms::LindstromTurk_cost<CollapsibleMesh>())
                           .get_placement(sms::LindstromTurk_placement<CollapsibleMesh>()));
    mesh.collect_garbage();
}

} // namespace isocast
