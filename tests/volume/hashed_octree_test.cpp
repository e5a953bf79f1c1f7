// Tests of the octree's cells and nodes against maps of them.
// SPDX-License-Identifier: MPL-2.0
#include "volume/hashed_octree.h"

#include "octree_oracle.h"
#include "temporary_folder.h"

namespace isocast {
namespace {

using test::OctreePair;
using test::Random;

void sample_zero(const Index3&, std::span<float> out) {
    std::ranges::fill(out, 0.0f);
}

/// Bit i of x, y, z at 3i, 3i + 1, 3i + 2.
std::uint64_t morton_code(const Index3& p) {
    std::uint64_t code = 0;
    for (int bit = 0; bit <= greatest_octree_depth; ++bit)
        for (int axis = 0; axis < 3; ++axis)
            code |= static_cast<std::uint64_t>(p[axis] >> bit & 1) << (3 * bit + axis);
    return code;
}

TEST(OctreeTable, HoldsWhatAMapHolds) {
    Random random(1);
    OctreeTable table;
    std::map<std::uint64_t, std::uint32_t> map;
    for (int i = 0; i < 100'000; ++i) {
        // Few keys, so that most are met again; runs of them, as neighbouring cells give.
        const auto key = static_cast<std::uint64_t>(test::random_int(random, 1, 200)) << i % 2 * 19;
        const OctreeTable::Entry* entry = table.find(key);
        ASSERT_EQ(entry != nullptr, map.contains(key));
        if (entry) {
            ASSERT_EQ(entry->links, map[key]);
            table.erase(key);
            map.erase(key);
        } else {
            map[key] = static_cast<std::uint32_t>(i);
            table.insert({.key = key, .links = map[key]});
        }
        ASSERT_EQ(table.size(), map.size());
    }
}

TEST(HashedOctree, IsAsMapsOfCellsAndNodesAreUnderRandomChanges) {
    for (int depth = 0; depth <= greatest_octree_depth; ++depth)
        test::expect_as_oracle(static_cast<std::uint32_t>(depth), depth, 1500, 5);
}

TEST(HashedOctree, IsTheRootAgainOnceAllIsMerged) {
    Random random(2);
    OctreePair pair(5);
    for (int i = 0; i < 400; ++i) pair.change(random, 0);
    ASSERT_GT(pair.tree.cell_count(), 1000u);
    while (pair.tree.cell_count() > 1) pair.change(random, 1);
    pair.expect_same();
    EXPECT_EQ(pair.tree.node_count(), 8u);
    // Numbers are given again: a second tree as large takes no more memory.
    const std::size_t bytes = pair.tree.memory_bytes();
    for (int i = 0; i < 300; ++i) pair.change(random, 0);
    EXPECT_EQ(pair.tree.memory_bytes(), bytes);
}

TEST(HashedOctree, VisitsLeavesInMortonsOrder) {
    Random random(3);
    OctreePair pair(greatest_octree_depth);
    for (int i = 0; i < 1000; ++i) pair.change(random, 0.2);
    std::uint64_t next = 0; // leaves fill the cube: each begins where the last one ends
    pair.tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
        if (!is_leaf) return;
        ASSERT_EQ(morton_code(cell.position), next);
        next += std::uint64_t{1} << 3 * cell.level;
    });
    EXPECT_EQ(next, std::uint64_t{1} << 3 * greatest_octree_depth);
}

TEST(HashedOctree, VisitsNodesInTheOrderInWhichDividingInVisitOrderMakesThem) {
    Random random(4);
    OctreePair pair(8);
    for (int i = 0; i < 1000; ++i) pair.change(random, 0.2);
    HashedOctree again(8, OctreeFilter::Linear, sample_zero);
    pair.tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
        if (!is_leaf) again.divide(cell, sample_zero);
    });
    HashedOctree::NodeNumber next = 0;
    pair.tree.visit_nodes([&](const Index3& position, HashedOctree::NodeNumber) {
        ASSERT_EQ(again.find_node(position), next++);
    });
    EXPECT_EQ(next, again.node_count());
}

TEST(HashedOctree, ChangesNothingIfTheSamplerThrows) {
    OctreePair pair(3);
    int calls = 0;
    const auto throw_at_the_third = [&](const Index3&, std::span<float>) {
        if (++calls == 3) throw ResourceError("enough");
    };
    EXPECT_THROW(pair.tree.divide(pair.tree.root(), throw_at_the_third), ResourceError);
    pair.expect_same();
    pair.tree.divide(pair.tree.root(), pair.sampler());
    pair.oracle.divide(pair.tree.root());
    pair.expect_same();
}

TEST(HashedOctree, RefusesWhatItCannotDo) {
    using test::message_of;
    EXPECT_EQ(message_of<InputError>([] { HashedOctree(21, OctreeFilter::Linear, sample_zero); }),
              "an octree's depth must be 0 to 20, and is 21");
    HashedOctree tree(1, OctreeFilter::Linear, sample_zero);
    tree.divide(tree.root(), sample_zero);
    const auto divide = [&](const OctreeCell& cell) {
        return message_of<InputError>([&] { tree.divide(cell, sample_zero); });
    };
    EXPECT_EQ(divide(tree.root()), "cannot divide cell (0, 0, 0) of level 1: it is no leaf");
    EXPECT_EQ(divide({{1, 0, 1}, 0}),
              "cannot divide cell (1, 0, 1) of level 0: it is of the finest");
    EXPECT_EQ(divide({{2, 0, 0}, 0}), "cannot divide cell (2, 0, 0) of level 0: there is none");
    EXPECT_EQ(message_of<InputError>([&] {
                  tree.merge({{1, 0, 1}, 0});
              }),
              "cannot merge the children of cell (1, 0, 1) of level 0: it has none");
}

TEST(HashedOctree, TakesPointsThatAreNoNumbersAsSomePlaceInside) {
    HashedOctree tree(3, OctreeFilter::Linear, sample_zero);
    tree.divide(tree.root(), sample_zero);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(tree.leaf_at({infinity, -infinity, std::nan("")}), (OctreeCell{{4, 0, 0}, 2}));
}

TEST(OctreeCursor, FindsTheLeafThatTheTreeFinds) {
    Random random(6);
    OctreePair pair(6);
    for (int i = 0; i < 300; ++i) pair.change(random, 0.2);
    OctreeCursor cursor(pair.tree);
    Vec3d p = Vec3d::Zero();
    for (int i = 0; i < 20'000; ++i) {
        // Steps of quarters, so that points lie on faces too, and now and then outside.
        for (int axis = 0; axis < 3; ++axis) p[axis] += test::random_int(random, -3, 3) / 4.0;
        if (i % 200 == 0) p = (4 * test::random_point(random, -1, 65)).array().round() / 4;
        ASSERT_EQ(cursor.find_leaf(p), pair.tree.find_leaf(p)) << p.transpose();
        ASSERT_EQ(cursor.value_at(p), pair.tree.value_at(p));
    }
}

/// The thesis's tree takes 36 bytes a cell, its table 25.
TEST(HashedOctree, TakesAtMost16BytesACellBesideItsNodes) {
    Random random(5);
    OctreePair pair(12);
    std::size_t last = 0;
    for (int i = 0; i < 3000; ++i) {
        pair.change(random, 0);
        if (pair.tree.cell_count() == last || pair.tree.cell_count() == 1) continue;
        last = pair.tree.cell_count();
        ASSERT_LE(pair.tree.table_bytes(), 16 * last);
    }
    EXPECT_GT(last, 10'000u);
}

} // namespace
} // namespace isocast
