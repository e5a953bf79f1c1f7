// Adaptive fields: cells of any sizes side by side, parts thinner than cells, any depth and scale.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert_adaptive.h"
#include "distance_transform/mesh_distance.h"
#include "distance_transform/sample_meshes.h"
#include "stability/cases.h"
#include "stability/random.h"
#include "stability/shapes.h"
#include "volume/octree_band.h"

#include <tbb/global_control.h>

#include <bit>

namespace isocast::stability {

namespace {

/// A mesh in the middle of [0, 2^depth]^3, 4 cells from its faces, with its distance.
struct InCells {
    InCells(const Mesh& mesh, int depth) : checked(check(placed(mesh, depth))) {}
    InCells(const InCells&) = delete;

    static Mesh placed(const Mesh& mesh, int depth) {
        const WorldBox bounds = bounding_box(mesh);
        const double scale = (std::exp2(depth) - 8) / bounds.size().maxCoeff();
        const Vec3d middle = 0.5 * (bounds.min + bounds.max);
        return mapped(mesh, [&](const Vec3d& p) {
            return Vec3d(scale * (p - middle) + Vec3d::Constant(std::exp2(depth - 1)));
        });
    }
    CheckedMesh checked;
    MeshDistance distance{checked.mesh, checked.topology, nullptr};
};

ExactDistance::Sample ball(const Vec3d& p, const Vec3d& centre, double radius) {
    const Vec3d offset = p - centre;
    return {offset.norm() - radius,
            offset.norm() > 0 ? Vec3d(offset.normalized()) : Vec3d(Vec3d::UnitX())};
}

/// Of values on both sides of faces between leaves, in roundings of a float of the greatest term.
Worst jumps(OctreeFilter filter) {
    constexpr int depth = 5;
    const InCells input(sample_mesh("knot"), depth);
    const HashedOctree tree =
        build_adaptive(input.distance, {.depth = depth, .filter = filter, .max_error_cells = 0.3});
    Random random(1);
    Worst worst;
    const auto greatest_of = [&](const OctreeCell& cell) {
        double greatest = 0;
        for (unsigned i = 0; i < 8; ++i) {
            const auto data = tree.data_of(tree.node_of(tree.find(cell).value(), i));
            double sum = 0;
            for (unsigned d = 0; d < data.size(); ++d)
                sum += std::abs(data[d]) * std::pow(cell.size(), std::popcount(d));
            greatest = std::max(greatest, sum);
        }
        return greatest;
    };
    tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
        if (!is_leaf) return;
        for (int axis = 0; axis < 3; ++axis) {
            if (cell.position[axis] == 0) continue;
            Vec3d p = cell.position.cast<double>();
            // Multiples of 2^-10, so that places in cells are exact.
            for (int a = 0; a < 3; ++a)
                if (a != axis) p[a] += std::floor(random.uniform(0, 1024)) * 0x1p-10 * cell.size();
            const OctreeCell beside = tree.leaf_at(p - Vec3d::Unit(axis) / 2);
            const auto at = [&](const OctreeCell& leaf) -> double {
                return interpolate(filter, tree.corners_of(tree.find(leaf).value()), leaf.size(),
                                   (p - leaf.position.cast<double>()) / leaf.size());
            };
            worst.see(std::abs(at(cell) - at(beside)) /
                      (0x1p-24 * std::max(greatest_of(cell), greatest_of(beside))));
        }
    });
    return worst;
}

/// On the surface, the value [finest cells] over what is allowed.
Worst error_on_the_surface(OctreeFilter filter) {
    Random random(2);
    Worst worst;
    for (const double max_error : {0.9, 0.1, 0.02}) {
        const Vec3d centre(15.7, 16.2, 16.1);
        const LipschitzDistance distance([&](const Vec3d& p) { return ball(p, centre, 9.3); });
        const HashedOctree tree =
            build_adaptive(distance, {.depth = 5, .filter = filter, .max_error_cells = max_error});
        // Finest cells of edge h err by at most 0.87 h.
        for (int i = 0; i < 3000; ++i)
            worst.see(std::abs(tree.value_at(centre + 9.3 * random.unit())) /
                      std::max(max_error, 0.87));
    }
    return worst;
}

/// Needles thirty times as long as thick and wider than a quarter of the error, in free space: each
/// must be in a finest cell or in the field. One at a time: none may be found by another's luck.
Worst needles_are_found() {
    constexpr int depth = 6;
    Random random(3);
    Worst worst;
    for (int i = 0; i < 40; ++i) {
        const double max_error = i % 2 ? 0.5 : 1.5;
        const double thickness = 0.4 * max_error;
        const Mat3d r = random.rotation();
        const Vec3d middle = Vec3d::Constant(32) + random.in_cube(16);
        const Mesh mesh = mapped(tetrahedron(), [&](const Vec3d& p) {
            return Vec3d(middle + r * (thickness * Vec3d(p.x(), p.y(), 30 * p.z())) / 2);
        });
        const CheckedMesh checked = check(mesh);
        const MeshDistance distance(checked.mesh, checked.topology, nullptr);
        const HashedOctree tree =
            build_adaptive(distance, {.depth = depth, .max_error_cells = max_error});
        bool is_found = false;
        for (const Vec3d& corner : checked.mesh.vertices_world)
            for (double t = 0; t < 1 && !is_found; t += 0x1p-6) {
                const Vec3d p = corner + t * (middle - corner);
                is_found = tree.leaf_at(p).level == 0 || tree.value_at(p) < 0;
            }
        worst.must(is_found);
    }
    return worst;
}

/// A ball of a fifth of a cell, anywhere in a root cell whose corners are far outside.
Worst specks_are_found() {
    Random random(4);
    Worst worst;
    for (int i = 0; i < 30; ++i) {
        const Vec3d centre = Vec3d::Constant(64) + random.in_cube(60);
        const LipschitzDistance distance([&](const Vec3d& p) { return ball(p, centre, 0.2); });
        const HashedOctree tree = build_adaptive(distance, {.depth = 7, .max_error_cells = {}});
        worst.must(tree.leaf_at(centre).level == 0);
    }
    return worst;
}

Worst depths_from_none() {
    Worst worst;
    for (int depth = 0; depth <= 6; ++depth) {
        const Vec3d middle = Vec3d::Constant(std::exp2(depth - 1));
        const LipschitzDistance distance(
            [&](const Vec3d& p) { return ball(p, middle, middle.x() / 2); });
        const HashedOctree tree =
            build_adaptive(distance, {.depth = depth, .max_error_cells = 0.01});
        // At nodes that do not hang the distance itself, rounded once.
        tree.visit_nodes([&](const Index3& at, HashedOctree::NodeNumber node) {
            if (tree.is_constrained(node)) return;
            const double d = ball(at.cast<double>(), middle, middle.x() / 2).distance;
            worst.must(tree.data_of(node)[0] == static_cast<float>(d));
        });
    }
    return worst;
}

std::vector<float> content(const HashedOctree& tree) {
    std::vector<float> all;
    tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
        for (const int i : cell.position) all.push_back(static_cast<float>(i));
        all.push_back(static_cast<float>(2 * cell.level + is_leaf));
        for (const auto node : tree.nodes_of(tree.find(cell).value()))
            for (const float value : tree.data_of(node)) all.push_back(value);
    });
    return all;
}

Worst threads_do_not_matter() {
    const InCells input(sample_mesh("knot"), 5);
    const auto with = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return content(build_adaptive(input.distance, {.depth = 5, .max_error_cells = 0.3}));
    };
    Worst worst;
    worst.must(with(1) == with(2));
    return worst;
}

/// The tree of a mesh times a power of two, whose values are scaled likewise.
Worst scales_exactly(int exponent) {
    const double scale = std::exp2(exponent);
    const Mesh mesh = noisy_sphere(2, 2);
    const auto tree_of = [](const Mesh& input, double error) {
        return convert_adaptive(check(input), {.max_error_world = error}).tree;
    };
    const HashedOctree one = tree_of(mesh, 0.05);
    const HashedOctree other = tree_of(scaled(mesh, scale), 0.05 * scale);
    Worst worst;
    worst.must(one.node_count() == other.node_count());
    for (HashedOctree::NodeNumber node = 0; node < std::min(one.node_count(), other.node_count());
         ++node)
        worst.must(static_cast<float>(one.data_of(node)[0] * scale) == other.data_of(node)[0]);
    return worst;
}

Worst band_has_the_trees_values() {
    const InCells input(sample_mesh("torus"), 5);
    const auto tree = std::make_shared<const HashedOctree>(
        build_adaptive(input.distance, {.depth = 5, .max_error_cells = 0.2}));
    const SparseField band = band_of_octree(tree, GridSpace::uniform(1), 0, 3);
    Worst worst;
    for (const FieldBlock& block : band.blocks())
        for (int i = 0; i < samples_per_block; ++i) {
            if (!block.active[static_cast<std::size_t>(i)]) continue;
            const Index3 at = block_size * block.coordinate + Index3(i % 8, i / 8 % 8, i / 64);
            worst.must(block.values[static_cast<std::size_t>(i)] ==
                       tree->value_at(at.cast<double>()));
        }
    return worst;
}

} // namespace

void append_octree_cases(std::vector<Case>& cases) {
    const auto add = [&](const char* name, const char* compares, double bound, const char* from,
                         auto run) {
        cases.push_back({std::string("octree.") + name, compares, bound, from,
                         [run](Devices&) { return run(); }});
    };
    const char* jumps_are = "values on both sides of faces between leaves of any sizes [roundings]";
    const char* two_a_level = "two roundings for each of 5 levels of hanging nodes, and two";
    add("hanging-faces-linear", jumps_are, 12, two_a_level,
        [] { return jumps(OctreeFilter::Linear); });
    add("hanging-faces-cubic", jumps_are, 12, two_a_level,
        [] { return jumps(OctreeFilter::Cubic); });
    for (const OctreeFilter filter : {OctreeFilter::Linear, OctreeFilter::Cubic})
        add(filter == OctreeFilter::Linear ? "error-of-a-sphere-linear" : "error-of-a-sphere-cubic",
            "values on a sphere and zero [allowed error, 0.87 finest cells at least]", 1,
            "proved for every point of the surface",
            [filter] { return error_on_the_surface(filter); });
    add("needles", "needles in free space, that no node sees, are in the tree", 0,
        "each holds a ball of a quarter of the error", needles_are_found);
    add("specks", "balls of a fifth of a cell in a root of 128 are in finest cells", 0,
        "Lipschitz's bound", specks_are_found);
    add("depths-from-0", "nodes of trees of depth 0 to 6 and distances", 0, "rounded once",
        depths_from_none);
    add("threads-1-and-2", "trees built by 1 and 2 threads", 0, "bit for bit",
        threads_do_not_matter);
    add("scale-2^-40", "trees of a mesh and of the same 2^-40 times as large", 0, "bit for bit",
        [] { return scales_exactly(-40); });
    add("scale-2^40", "trees of a mesh and of the same 2^40 times as large", 0, "bit for bit",
        [] { return scales_exactly(40); });
    add("band", "active samples of a tree's band and the tree's values", 0, "bit for bit",
        band_has_the_trees_values);
}

} // namespace isocast::stability
