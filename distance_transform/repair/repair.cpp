// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/repair/repair.h"

#include "volume/errors.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

#include <fmt/format.h>

namespace isocast {

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;

struct Soup {
    std::vector<Point> points;
    std::vector<std::vector<std::size_t>> polygons;
};

Soup soup_of(const Mesh& mesh) {
    Soup soup;
    for (const Vec3d& p : mesh.vertices_world) soup.points.emplace_back(p.x(), p.y(), p.z());
    for (const auto& [a, b, c] : mesh.triangles)
        soup.polygons.push_back({static_cast<std::size_t>(a), static_cast<std::size_t>(b),
                                 static_cast<std::size_t>(c)});
    return soup;
}

Mesh mesh_of(Surface& surface) {
    surface.collect_garbage(); // so that indices count from 0
    Mesh mesh;
    for (const auto vertex : surface.vertices()) {
        const Point& p = surface.point(vertex);
        mesh.vertices_world.emplace_back(p.x(), p.y(), p.z());
    }
    for (const auto face : surface.faces()) {
        const auto halfedge = surface.halfedge(face);
        const auto index = [&](auto h) { return static_cast<int>(surface.target(h).idx()); };
        mesh.triangles.push_back({index(halfedge), index(surface.next(halfedge)),
                                  index(surface.next(surface.next(halfedge)))});
    }
    return mesh;
}

int filling_triangles(Surface& surface, Surface::Halfedge_index border) {
    // The search without Delaunay's help takes the third power of the number of edges: a second
    // for these.
    constexpr std::size_t longest_cubic = 500;
    const bool is_long = CGAL::halfedges_around_face(border, surface).size() > longest_cubic;
    std::vector<Surface::Face_index> faces;
    pmp::triangulate_hole(surface, border, std::back_inserter(faces),
                          CGAL::parameters::use_2d_constrained_delaunay_triangulation(is_long)
                              .do_not_use_cubic_algorithm(is_long));
    return static_cast<int>(faces.size());
}

} // namespace

std::string RepairReport::summary() const {
    std::string text;
    const auto add = [&](int count, const char* what) {
        if (count > 0) text += fmt::format("{} {}; ", count, what);
    };
    add(removed_triangles, "degenerate or duplicate triangles removed");
    add(added_vertices, "vertices added where triangles met in no manifold way");
    if (holes > 0)
        text += fmt::format("{} of {} holes filled with {} triangles; ", filled_holes, holes,
                            filling_triangles);
    return text + (is_closed ? "closed" : "still open");
}

RepairedMesh repair(const Mesh& mesh) {
    RepairReport report;
    Soup soup = soup_of(mesh);
    pmp::repair_polygon_soup(soup.points, soup.polygons);
    if (soup.polygons.empty()) throw InputError("no triangle is left to repair");
    report.removed_triangles = static_cast<int>(mesh.triangles.size() - soup.polygons.size());
    const std::size_t point_count = soup.points.size();
    pmp::orient_polygon_soup(soup.points, soup.polygons);
    report.added_vertices = static_cast<int>(soup.points.size() - point_count);

    Surface surface;
    pmp::polygon_soup_to_polygon_mesh(soup.points, soup.polygons, surface);
    // An edge of two solids was cut for both of them; each closes again by itself.
    pmp::stitch_borders(surface, CGAL::parameters::apply_per_connected_component(true));
    std::vector<Surface::Halfedge_index> borders;
    pmp::extract_boundary_cycles(surface, std::back_inserter(borders));
    report.holes = static_cast<int>(borders.size());
    for (const auto border : borders) {
        const int count = filling_triangles(surface, border);
        report.filled_holes += count > 0 ? 1 : 0;
        report.filling_triangles += count;
    }
    report.is_closed = CGAL::is_closed(surface);
    if (report.is_closed) pmp::orient_to_bound_a_volume(surface);
    return {mesh_of(surface), report};
}

} // namespace isocast
