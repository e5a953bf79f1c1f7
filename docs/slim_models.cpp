// docs_slim_models FOLDER BUNNY: what docs/make_pictures draws for figures 3 and 12 of Stoll et al.
// 2006 in slim.md: a SLIM surface, what of it an eye is shown, and a mesh with as great an error.
// SPDX-License-Identifier: MPL-2.0
#include "docs/program.h"

#include "bench/slim/edge_collapse.h"
#include "distance_transform/checked_mesh.h"
#include "distance_transform/mesh_files.h"
#include "quadrics/slim_cover.h"
#include "quadrics/slim_file.h"

#include <filesystem>

namespace {

using namespace isocast;

Mesh simplified(const TriangleMesh& from, std::size_t triangles) {
    CollapsibleMesh mesh = collapsible(from);
    collapse_edges(mesh, triangles * 3 / 2);
    return mesh_of(mesh);
}

} // namespace

int main(int argc, char** argv) {
    return run_program(argc, "docs_slim_models FOLDER BUNNY", [&] {
        const std::filesystem::path folder = argv[1];
        const CheckedMesh checked = check(read_mesh(argv[2]));
        const TriangleMesh mesh{.vertices_world = checked.mesh.vertices_world,
                                .triangles = checked.mesh.triangles};
        const WorldBox box = bounding_box(checked.mesh);
        std::vector<SlimReport> reports;
        SlimSurface surface =
            slim_of(mesh, {.max_error_world = 1e-3 * box.size().norm(), .max_levels = 1}, reports);
        write_slim(surface, folder / "slim_all.slim");
        // bench_slim: a mesh with the same greatest error has 8.5 triangles a patch.
        const double triangles = 8.5 * static_cast<double>(surface.patch_count());
        write_mesh(simplified(mesh, static_cast<std::size_t>(triangles)),
                   folder / "slim_triangles.ply");
        // Figure 3: seen from three diagonals to its left, in front of the pictures.
        const Vec3d eye = (box.min + box.max) / 2 - 3 * box.size().norm() * Vec3d(0.97, 0, -0.24);
        std::erase_if(surface.levels.front().patches, [&](const SlimPatch& patch) {
            return is_turned_away(patch, eye, true, Vec3d::Zero());
        });
        surface.is_closed = false;
        write_slim(surface, folder / "slim_culled.slim");
    });
}
