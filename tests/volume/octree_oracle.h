// An octree as a map of cells and a map of nodes, and random changes that it and ours go through.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "random_fields.h"
#include "volume/errors.h"
#include "volume/hashed_octree.h"

#include <map>
#include <set>

namespace isocast::test {

struct ZyxLess {
    bool operator()(const Index3& a, const Index3& b) const { return zyx_less(a, b); }
};
struct CellLess {
    bool operator()(const OctreeCell& a, const OctreeCell& b) const {
        return a.level != b.level ? a.level < b.level : zyx_less(a.position, b.position);
    }
};

inline Index3 corner_of(const OctreeCell& cell, int i) {
    return cell.position + cell.size() * Index3(i & 1, i >> 1 & 1, i >> 2);
}

/// The same by definition: all cells, and how many of them have each node as a corner.
class OctreeOracle {
public:
    explicit OctreeOracle(int depth) : depth_(depth) { add({Index3::Zero(), depth}); }

    const std::map<OctreeCell, bool, CellLess>& cells() const { return is_divided_; }
    const std::map<Index3, int, ZyxLess>& nodes() const { return uses_; }
    bool has(const OctreeCell& cell) const { return is_divided_.contains(cell); }
    bool is_divided(const OctreeCell& cell) const { return has(cell) && is_divided_.at(cell); }

    void divide(const OctreeCell& cell) {
        is_divided_[cell] = true;
        for (int i = 0; i < 8; ++i) add(child_of(cell, i));
    }
    bool can_merge(const OctreeCell& cell) const {
        if (!is_divided(cell)) return false;
        for (int i = 0; i < 8; ++i)
            if (is_divided(child_of(cell, i))) return false;
        return true;
    }
    void merge(const OctreeCell& cell) {
        is_divided_[cell] = false;
        for (int i = 0; i < 8; ++i) remove(child_of(cell, i));
    }

    bool is_inside(const Index3& finest) const {
        return (finest.array() >= 0).all() && (finest.array() < 1 << depth_).all();
    }
    /// The smallest cell of at least `level` that holds a finest cell.
    OctreeCell cell_at(const Index3& finest, int level) const {
        for (;; ++level) {
            const OctreeCell cell = {floor_div(finest, 1 << level) * (1 << level), level};
            if (has(cell)) return cell;
        }
    }
    /// True if one of the leaves around a node does not have it as a corner.
    bool is_hanging(const Index3& position) const {
        if (!uses_.contains(position)) return false;
        for (int i = 0; i < 8; ++i) {
            const Index3 finest = corner_of({position - Index3::Ones(), 0}, i);
            if (!is_inside(finest)) continue;
            const OctreeCell leaf = cell_at(finest, 0);
            bool is_corner = false;
            for (int j = 0; j < 8; ++j) is_corner |= corner_of(leaf, j) == position;
            if (!is_corner) return true;
        }
        return false;
    }

private:
    void add(const OctreeCell& cell) {
        is_divided_[cell] = false;
        for (int i = 0; i < 8; ++i) ++uses_[corner_of(cell, i)];
    }
    void remove(const OctreeCell& cell) {
        is_divided_.erase(cell);
        for (int i = 0; i < 8; ++i)
            if (--uses_[corner_of(cell, i)] == 0) uses_.erase(corner_of(cell, i));
    }

    int depth_;
    std::map<OctreeCell, bool, CellLess> is_divided_;
    std::map<Index3, int, ZyxLess> uses_;
};

/// Finest cells in and out of the tree, in clusters of all sizes about a few places, so that trees
/// get deep.
inline Index3 random_finest(Random& random, int depth) {
    const int side = 1 << depth;
    const Index3 focus = Index3(5, 3, 6) * random_int(random, 0, 1) * (side / 8);
    Index3 finest;
    const int reach = 1 << random_int(random, 0, depth);
    for (int axis = 0; axis < 3; ++axis) finest[axis] = focus[axis] + random_int(random, -2, reach);
    return finest;
}

/// Both trees, changed alike. Node values are 0, 1, 2, … in the order of sampling (linear filter).
struct OctreePair {
    explicit OctreePair(int depth) : oracle(depth), tree(depth, OctreeFilter::Linear, sampler()) {}
    OctreePair(const OctreePair&) = delete;
    OctreePair& operator=(const OctreePair&) = delete;

    HashedOctree::NodeSampler sampler() {
        return [this](const Index3& position, std::span<float> out) {
            EXPECT_TRUE(values.emplace(position, next_value).second) << position.transpose();
            out[0] = next_value++;
        };
    }

    void change(Random& random, double probability_of_merge) {
        const Index3 finest = random_finest(random, tree.depth());
        const bool divides = random_real(random, 0, 1) >= probability_of_merge;
        change_at(finest,
                  divides ? std::nullopt : std::optional(random_int(random, 0, tree.depth())));
    }
    /// Divides the leaf there, or merges the children of the cell of at least a level.
    void change_at(const Index3& finest, std::optional<int> merged_level) {
        if (!oracle.is_inside(finest)) return;
        if (!merged_level) {
            const OctreeCell leaf = oracle.cell_at(finest, 0);
            if (leaf.level == 0) {
                EXPECT_THROW(tree.divide(leaf, sampler()), InputError);
                return;
            }
            tree.divide(leaf, sampler());
            oracle.divide(leaf);
            return;
        }
        const OctreeCell cell = oracle.cell_at(finest, *merged_level);
        if (!oracle.can_merge(cell)) {
            EXPECT_THROW(tree.merge(cell), InputError);
            return;
        }
        tree.merge(cell);
        oracle.merge(cell);
        for (int i = 0; i < 8; ++i)
            for (int j = 0; j < 8; ++j)
                if (!oracle.nodes().contains(corner_of(child_of(cell, i), j)))
                    values.erase(corner_of(child_of(cell, i), j));
    }

    void expect_same_look_ups(Random& random) const {
        const Index3 finest = random_finest(random, tree.depth());
        const int level = random_int(random, 0, tree.depth());
        // Places at odds with the size too.
        const int step = 1 << std::max(level - random_int(random, 0, 1), 0);
        const OctreeCell cell = {floor_div(finest, step) * step, level};
        ASSERT_EQ(tree.find(cell).has_value(), oracle.has(cell));
        ASSERT_EQ(tree.is_divided(cell), oracle.is_divided(cell));
        const auto node = tree.find_node(finest);
        ASSERT_EQ(node.has_value(), oracle.nodes().contains(finest)) << finest.transpose();
        if (node) {
            ASSERT_EQ(tree.data_of(*node)[0], values.at(finest));
        }
        ASSERT_EQ(tree.is_hanging(finest), oracle.is_hanging(finest)) << finest.transpose();

        const Index3 inside = finest.cwiseMax(0).cwiseMin((1 << tree.depth()) - 1);
        const Vec3d p = finest.cast<double>() + random_point(random, 0, 1);
        ASSERT_EQ(tree.leaf_at(p), oracle.cell_at(inside, 0)) << p.transpose();
        const OctreeCell there = oracle.cell_at(inside, level);
        const int axis = random_int(random, 0, 2);
        const bool upwards = random_int(random, 0, 1) == 1;
        const Index3 beside =
            there.position + Index3::Unit(axis) * (upwards ? there.size() : -there.size());
        const auto neighbour = tree.neighbour(there, axis, upwards);
        ASSERT_EQ(neighbour.has_value(), oracle.is_inside(beside));
        if (neighbour) {
            ASSERT_EQ(*neighbour, oracle.cell_at(beside, there.level));
        }
    }

    void expect_same() const {
        ASSERT_EQ(tree.cell_count(), oracle.cells().size());
        std::set<OctreeCell, CellLess> visited;
        std::size_t leaves = 0;
        tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
            ASSERT_TRUE(oracle.has(cell));
            ASSERT_EQ(is_leaf, !oracle.is_divided(cell));
            ASSERT_TRUE(visited.insert(cell).second);
            ASSERT_TRUE(cell.level == tree.depth() || visited.contains(parent_of(cell)));
            leaves += is_leaf;
            const auto nodes = tree.nodes_of(tree.find(cell).value());
            for (int i = 0; i < 8; ++i)
                ASSERT_EQ(tree.data_of(nodes[static_cast<std::size_t>(i)])[0],
                          values.at(corner_of(cell, i)));
        });
        ASSERT_EQ(visited.size(), tree.cell_count());
        ASSERT_EQ(leaves, tree.leaf_count());
        ASSERT_EQ(tree.node_count(), oracle.nodes().size());
        ASSERT_EQ(values.size(), oracle.nodes().size());
        std::set<HashedOctree::NodeNumber> numbers;
        tree.visit_nodes([&](const Index3& position, HashedOctree::NodeNumber node) {
            ASSERT_TRUE(oracle.nodes().contains(position));
            ASSERT_TRUE(numbers.insert(node).second);
            ASSERT_EQ(tree.find_node(position), node);
        });
        ASSERT_EQ(numbers.size(), tree.node_count());
    }

    std::map<Index3, float, ZyxLess> values;
    float next_value = 0;
    OctreeOracle oracle;
    HashedOctree tree;
};

/// Changes and look-ups, more divisions and more merges in turns; all is compared at the end, and
/// `often` between.
inline void expect_as_oracle(std::uint32_t seed, int depth, int changes, int often) {
    Random random(seed);
    OctreePair pair(depth);
    for (int i = 0; i < changes && !::testing::Test::HasFatalFailure(); ++i) {
        pair.change(random, i / 100 % 3 == 2 ? 0.8 : 0.3);
        pair.expect_same_look_ups(random);
        if (i % std::max(changes / often, 1) == 0) pair.expect_same();
    }
    pair.expect_same();
}

} // namespace isocast::test
