// The tree that is built: continuous, the same for any number of threads, as deep as was asked.
// SPDX-License-Identifier: MPL-2.0
#include "../../volume/octree_jumps.h"
#include "adaptive_fields.h"
#include "bench/adaptive/thesis_builders.h"
#include "volume/errors.h"

#include <tbb/global_control.h>

namespace isocast::test {
namespace {

TEST(AdaptiveTree, IsContinuousAcrossFacesOfCellsOfAnySizes) {
    constexpr int depth = 6;
    std::size_t hanging_nodes = 0;
    for (const std::string name : {"knot", "seashell"}) {
        const MeshInCells input(mesh_in_cells(sample_mesh(name), depth));
        for (const OctreeFilter filter : octree_filters) {
            for (const std::optional<double> max_error : {std::optional(0.3), {}}) {
                const HashedOctree tree = build_adaptive(
                    input.distance(),
                    {.depth = depth, .filter = filter, .max_error_cells = max_error});
                for (HashedOctree::NodeNumber node = 0; node < tree.node_count(); ++node)
                    hanging_nodes += tree.is_constrained(node);
                Random random(1);
                // As OctreeInterpolant's tests: a level of constraints rounds twice at most.
                EXPECT_LE(greatest_jump(tree, random, false), 2 * depth + 2) << name;
                if (filter == OctreeFilter::Cubic) {
                    EXPECT_LE(greatest_jump(tree, random, true), 2 * depth + 2) << name;
                }
            }
        }
    }
    EXPECT_GT(hanging_nodes, 10'000u);
}

TEST(AdaptiveTree, SameForAnyNumberOfThreads) {
    constexpr int depth = 6;
    const MeshInCells input(mesh_in_cells(sample_mesh("knot"), depth));
    for (const OctreeFilter filter : octree_filters) {
        for (const std::optional<double> max_error : {std::optional(0.5), {}}) {
            std::vector<TreeContent> trees;
            for (const std::size_t threads : {1, 2, 7}) {
                const tbb::global_control some(tbb::global_control::max_allowed_parallelism,
                                               threads);
                trees.emplace_back(build_adaptive(
                    input.distance(),
                    {.depth = depth, .filter = filter, .max_error_cells = max_error}));
            }
            EXPECT_TRUE(trees[0] == trees[1]);
            EXPECT_TRUE(trees[0] == trees[2]);
            EXPECT_GT(trees[0].cells.size(), 1000u);
        }
    }
}

// Nodes that do not hang hold the distance, rounded once, and its gradient.
TEST(AdaptiveTree, NodesThatDoNotHangHoldTheDistance) {
    constexpr int depth = 6;
    const MeshInCells input(mesh_in_cells(sample_mesh("torus"), depth));
    for (const OctreeFilter filter : octree_filters) {
        const HashedOctree tree = build_adaptive(
            input.distance(), {.depth = depth, .filter = filter, .max_error_cells = 1});
        int seen = 0;
        tree.visit_nodes([&](const Index3& position, HashedOctree::NodeNumber node) {
            EXPECT_EQ(tree.is_constrained(node), tree.is_hanging(position));
            if (tree.is_constrained(node)) return;
            ++seen;
            ExactDistance::Hint hint = 0;
            const auto [distance, gradient] = input.distance().at(position.cast<double>(), hint);
            const auto data = tree.data_of(node);
            // Two triangles may be as near but for rounding: the order of search decides.
            EXPECT_NEAR(data[0], distance, ulp(static_cast<float>(distance)));
            if (filter == OctreeFilter::Linear) return;
            const Vec3d slopes(data[1], data[2], data[4]);
            EXPECT_NEAR(slopes.norm(), 1, 1e-6); // three floats
            EXPECT_EQ(data[3], 0);
            EXPECT_EQ(data[5], 0);
            EXPECT_EQ(data[6], 0);
            EXPECT_EQ(data[7], 0);
        });
        EXPECT_GT(seen, 100);
    }
}

TEST(AdaptiveTree, DepthsFromNoneOnAreBuilt) {
    for (int depth = 0; depth <= 4; ++depth) {
        const Vec3d middle = Vec3d::Constant(std::exp2(depth - 1));
        const LipschitzDistance distance(
            [&](const Vec3d& p) { return sphere_distance(p, middle, middle.x() / 2); });
        for (const std::optional<double> max_error : {std::optional(0.1), {}}) {
            const HashedOctree tree =
                build_adaptive(distance, {.depth = depth, .max_error_cells = max_error});
            EXPECT_EQ(tree.depth(), depth);
            EXPECT_TRUE(depth == 0 || tree.is_divided(tree.root()));
        }
    }
    const LipschitzDistance anything(
        [](const Vec3d& p) { return sphere_distance(p, Vec3d::Zero(), 1); });
    EXPECT_THROW(build_adaptive(anything, {.depth = greatest_octree_depth + 1}), InputError);
    EXPECT_THROW(build_adaptive(anything, {.depth = -1}), InputError);
}

TEST(AdaptiveTree, CancelIsHeeded) {
    const MeshInCells input(mesh_in_cells(sample_mesh("torus"), 6));
    EXPECT_THROW(build_adaptive(input.distance(), {.depth = 6},
                                [](std::string_view, double) { throw Interrupted(); }),
                 Interrupted);
}

// The thesis's builders are what they are measured as: bottom up none of the cells with nodes on
// both sides is missed, looking ahead far enough finds as many, and corners alone find no others.
TEST(ThesisBuilders, BottomUpHasAllCellsThatNodesTellAndTopDownSomeOfThem) {
    constexpr int depth = 6;
    const MeshInCells input(mesh_in_cells(sample_mesh("seashell"), depth));
    const HashedOctree all = built_bottom_up(input.distance(), depth).tree;
    const HashedOctree corners = built_top_down(input.distance(), depth, 0).tree;
    const HashedOctree ahead = built_top_down(input.distance(), depth, depth).tree;
    std::vector<float> values(65 * 65 * 65);
    ExactDistance::Hint hint = 0;
    for (int i = 0; i < std::ssize(values); ++i)
        values[static_cast<std::size_t>(i)] = static_cast<float>(
            input.distance().at(Vec3d(i % 65, i / 65 % 65, i / (65 * 65)), hint).distance);
    int cut_count = 0;
    int seen_by_corners = 0;
    for_each_sample({Index3::Zero(), Index3::Constant(64)}, [&](const Index3& at) {
        int inside = 0;
        for (int k = 0; k < 8; ++k)
            inside += values[static_cast<std::size_t>(
                          (at.x() + (k & 1)) +
                          65 * ((at.y() + (k >> 1 & 1)) + 65 * (at.z() + (k >> 2))))] < 0;
        if (inside == 0 || inside == 8) return;
        ++cut_count;
        EXPECT_TRUE(all.find({at, 0}));
        EXPECT_TRUE(ahead.find({at, 0}));
        seen_by_corners += corners.find({at, 0}).has_value();
    });
    EXPECT_GT(cut_count, 1000);
    EXPECT_LE(seen_by_corners, cut_count);
    corners.visit_cells([&](const OctreeCell& cell, bool) {
        if (cell.level + 3 < depth) {
            EXPECT_TRUE(all.find(cell));
        }
    });
}

} // namespace
} // namespace isocast::test
