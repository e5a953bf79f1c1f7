// docs_slim_pictures FOLDER BUNNY: figures 3 and 12 of Stoll et al. 2006, of one bunny, for
// slim.md. SPDX-License-Identifier: MPL-2.0
#include "docs/slice.h"

#include "distance_transform/checked_mesh.h"
#include "distance_transform/mesh_files.h"
#include "gl/context.h"
#include "quadrics/slim_cover.h"
#include "raycaster/renderer.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <fmt/format.h>

#include <cmath>

namespace {

using namespace isocast;

constexpr int size = 480; // of a picture [pixels]

Image drawn(Renderer& renderer, Primitives primitives, const Camera& camera, const Look& look) {
    renderer.load(
        {.look = look, .primitives = std::make_shared<Primitives>(std::move(primitives))});
    renderer.draw(camera, 2 * size, 2 * size, {FrameImage::Beauty});
    const Image fine = renderer.read(FrameImage::Beauty);
    Image out{.width = size, .height = size, .rgba = {}};
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            for (int k = 0; k < 4; ++k)
                out.rgba.push_back((fine.pixel(2 * x, 2 * y)[k] + fine.pixel(2 * x + 1, 2 * y)[k] +
                                    fine.pixel(2 * x, 2 * y + 1)[k] +
                                    fine.pixel(2 * x + 1, 2 * y + 1)[k]) /
                                   4);
    return out;
}

/// Figure 3: all pieces, and those that an eye in front of the right picture's left side is shown.
Image culled(Renderer& renderer, SlimSurface surface, const Camera& camera) {
    surface.is_closed = false; // both sides of all show
    const Image all = drawn(renderer, {.slims = {surface}}, camera, {});
    const Vec3d back = (camera.eye_world - camera.target_world).normalized();
    const Vec3d right = camera.up.cross(back).normalized();
    const Vec3d eye = camera.target_world - (camera.eye_world - camera.target_world).norm() * right;
    std::erase_if(surface.levels.front().patches, [&](const SlimPatch& patch) {
        return is_turned_away(patch, eye, true, Vec3d::Zero());
    });
    return beside(all, drawn(renderer, {.slims = {surface}}, camera, {}));
}

/// By edge collapse, with normals at vertices by the faces' angles.
TriangleMesh simplified(const TriangleMesh& from, std::size_t triangles) {
    using Surface = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;
    namespace sms = CGAL::Surface_mesh_simplification;
    Surface mesh;
    for (const Vec3d& p : from.vertices_world) mesh.add_vertex({p.x(), p.y(), p.z()});
    for (const auto& [a, b, c] : from.triangles) {
        const auto vertex = [](int i) {
            return Surface::Vertex_index(static_cast<Surface::size_type>(i));
        };
        mesh.add_face(vertex(a), vertex(b), vertex(c));
    }
    sms::edge_collapse(mesh, sms::Count_stop_predicate<Surface>(triangles * 3 / 2),
                       CGAL::parameters::get_cost(sms::LindstromTurk_cost<Surface>())
                           .get_placement(sms::LindstromTurk_placement<Surface>()));
    mesh.collect_garbage();
    TriangleMesh out;
    for (const auto v : mesh.vertices()) {
        const auto& p = mesh.point(v);
        out.vertices_world.emplace_back(p.x(), p.y(), p.z());
    }
    std::vector<Vec3d> normals(out.vertices_world.size(), Vec3d::Zero());
    for (const auto face : mesh.faces()) {
        auto& corners = out.triangles.emplace_back();
        std::size_t k = 0;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(face)))
            corners[k++] = static_cast<int>(v);
        for (k = 0; k < 3; ++k) {
            const auto at = [&](std::size_t corner) -> const Vec3d& {
                return out.vertices_world[static_cast<std::size_t>(corners[(k + corner) % 3])];
            };
            const Vec3d a = at(1) - at(0);
            const Vec3d b = at(2) - at(0);
            const Vec3d n = a.cross(b);
            normals[static_cast<std::size_t>(corners[k])] +=
                std::atan2(n.norm(), a.dot(b)) * n.normalized();
        }
    }
    for (const auto& corners : out.triangles)
        for (const int corner : corners)
            out.normals_world.push_back(
                normals[static_cast<std::size_t>(corner)].normalized().cast<float>());
    return out;
}

/// Figure 12: stripes mirrored by the pieces, and by a mesh with as great an error.
Image mirrored(Renderer& renderer, const SlimSurface& surface, const TriangleMesh& mesh,
               const Camera& camera) {
    Look look;
    look.environment = {.kind = Environment::Kind::Stripes, .stripes = 40};
    look.effects.reflection.strength = 1;
    return beside(drawn(renderer, {.slims = {surface}}, camera, look),
                  drawn(renderer, {.meshes = {mesh}}, camera, look));
}

} // namespace

int main(int argc, char** argv) {
    try {
        if (argc != 3) {
            fmt::print(stderr, "usage: docs_slim_pictures FOLDER BUNNY\n");
            return 2;
        }
        const std::filesystem::path folder = argv[1];
        const CheckedMesh checked = check(read_mesh(argv[2]));
        const TriangleMesh mesh{.vertices_world = checked.mesh.vertices_world,
                                .triangles = checked.mesh.triangles};
        Eigen::AlignedBox3d box;
        for (const Vec3d& vertex : mesh.vertices_world) box.extend(vertex);
        std::vector<SlimReport> reports;
        const SlimSurface surface = slim_of(
            mesh, {.max_error_world = 1e-3 * box.diagonal().norm(), .max_levels = 1}, reports);
        const auto context = gl::make_context({.backend = gl::Backend::Osmesa});
        Renderer renderer(*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders");
        renderer.load({.primitives = std::make_shared<Primitives>(Primitives{.slims = {surface}})});
        Camera camera = frame_box(renderer.surface_points_world(), {0.25, 0.2, 1}, 1, 30);
        write_png(culled(renderer, surface, camera), folder / "slim_culled.png");
        // The head, twice as large. bench_slim: 5.9 triangles a patch have the same greatest error.
        camera.target_world = box.center() + box.sizes().cwiseProduct(Vec3d(-0.2, 0.22, 0));
        camera.fov_y_degrees /= 2;
        const auto triangles =
            static_cast<std::size_t>(5.9 * static_cast<double>(surface.patch_count()));
        write_png(mirrored(renderer, surface, simplified(mesh, triangles), camera),
                  folder / "slim_mirrored.png");
        return 0;
    } catch (const std::exception& error) {
        fmt::print(stderr, "docs_slim_pictures: {}\n", error.what());
        return 1;
    }
}
