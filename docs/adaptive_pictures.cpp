// docs_adaptive_pictures FOLDER BUNNY: thesis figures 3.1 and 3.4 for octree.md.
// SPDX-License-Identifier: MPL-2.0
#include "docs/program.h"
#include "docs/slice.h"

#include "bench/adaptive/mesh_in_cells.h"
#include "bench/adaptive/thesis_builders.h"
#include "distance_transform/adaptive.h"
#include "distance_transform/checked_mesh.h"
#include "distance_transform/mesh_distance.h"
#include "distance_transform/mesh_files.h"

#include <fmt/format.h>

#include <filesystem>
#include <functional>

namespace {

using namespace isocast;

/// A square of a plane of constant z [finest cells].
struct Square {
    Vec3d lo;
    double edge;
};

/// The field of a tree with its cells; red where the surface truly is and the tree has none.
Image cells_of(const HashedOctree& tree, const Square& square, int width,
               const std::function<double(const Vec3d&)>& exact) {
    const double pixels_per_cell = width / square.edge;
    const auto point = [&](int x, int y) -> Vec3d {
        return square.lo + Vec3d(x + 0.5, y + 0.5, 0) / pixels_per_cell;
    };
    // A line where the side changes within a pixel, so that it is as wide where slopes are small.
    const auto is_line = [&](const auto& value_at, int x, int y) {
        const bool is_inside = value_at(point(x, y)) < 0;
        for (int v = -1; v <= 1; ++v)
            for (int u = -1; u <= 1; ++u)
                if ((value_at(point(x + u, y + v)) < 0) != is_inside) return true;
        return false;
    };
    const auto value_at = [&](const Vec3d& p) { return double{tree.value_at(p)}; };
    SliceCanvas slice({Index3::Zero(), {width, width, 1}});
    for (int y = 0; y < width; ++y)
        for (int x = 0; x < width; ++x) {
            const OctreeCell leaf = tree.leaf_at(point(x, y));
            Colour colour = 0.6f * distance_colour(pixels_per_cell * value_at(point(x, y))) +
                            Colour::Constant(0.4f);
            if (leaf != tree.leaf_at(point(x + 1, y)) || leaf != tree.leaf_at(point(x, y + 1)))
                colour = 0.3f * colour + Colour::Constant(0.1f);
            if (is_line(exact, x, y)) colour = Colour(0.9f, 0, 0);
            if (is_line(value_at, x, y)) colour = Colour::Zero();
            slice.set({x, y, 0}, colour);
        }
    return slice.image();
}

/// Thesis figure 3.1: a slice through an ear and the back, and the tip of the ear larger.
Image adaptive_sampling(const std::filesystem::path& bunny) {
    constexpr int depth = 8;
    const CheckedMesh mesh = check(mesh_in_cells(read_mesh(bunny), depth));
    const MeshDistance distance(mesh.mesh, mesh.topology, nullptr);
    const HashedOctree tree = build_adaptive(distance, {.depth = depth, .max_error_cells = 0.3});
    const auto exact = [&](const Vec3d& p) {
        ExactDistance::Hint hint = 0;
        return distance.at(p, hint).distance;
    };
    constexpr double z = 128.3; // inside cells of all sizes
    return beside(cells_of(tree, {{0, 0, z}, 256}, 512, exact),
                  cells_of(tree, {{64, 186, z}, 48}, 512, exact));
}

/// Thesis figure 3.4: a ball with a needle on it, and specks of three sizes beside it.
Image missed_features() {
    constexpr int depth = 7;
    constexpr double z = 68.8;
    const auto ball = [](const Vec3d& p, const Vec3d& centre, double radius) {
        return ExactDistance::Sample{(p - centre).norm() - radius, (p - centre).normalized()};
    };
    const LipschitzDistance shape([&](const Vec3d& p) {
        ExactDistance::Sample nearest = ball(p, {50.6, 51.2, z}, 29.4);
        const Vec3d root(60, 60, z);
        const Vec3d along = Vec3d(117, 93, z) - root;
        const double t = std::clamp((p - root).dot(along) / along.squaredNorm(), 0.0, 1.0);
        for (const ExactDistance::Sample& other :
             {ball(p, root + t * along, 0.9), ball(p, {102.8, 26.6, z}, 5.2),
              ball(p, {72.4, 104.6, z}, 2.6), ball(p, {25.2, 106.8, z}, 1)})
            if (other.distance < nearest.distance) nearest = other;
        return nearest;
    });
    const auto exact = [&](const Vec3d& p) {
        ExactDistance::Hint hint = 0;
        return shape.at(p, hint).distance;
    };
    const auto picture_of = [&](const HashedOctree& tree) {
        return cells_of(tree, {{0, 0, z}, 128}, 384, exact);
    };
    return beside(beside(picture_of(built_top_down(shape, depth, 0).tree),
                         picture_of(built_top_down(shape, depth, 2).tree)),
                  picture_of(build_adaptive(shape, {.depth = depth, .max_error_cells = 0.4})));
}

} // namespace

int main(int argc, char** argv) {
    return run_program(argc, "docs_adaptive_pictures FOLDER BUNNY", [&] {
        const std::filesystem::path folder = argv[1];
        write_png(missed_features(), folder / "octree_features.png");
        write_png(adaptive_sampling(argv[2]), folder / "octree_cells.png");
    });
}
