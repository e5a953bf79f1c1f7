// An octree without pointers: a hash table finds eight sibling cells by place and size.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/octree_cell.h"
#include "volume/octree_interpolant.h"
#include "volume/octree_table.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace isocast {

/// Cells over [0, 2^depth]^3, each of which may be divided into eight, and values at their corners
/// (nodes), which up to eight cells share.
///
/// Siblings are born and die together, so that one entry of the table stands for eight cells:
///
///     table   place and size of a divided cell ─► its links, and which children are divided
///     links   the numbers of the 27 corners of eight siblings, x fastest
///     nodes   components_of(filter) floats each
///
/// source  Sigg 2006 (thesis), chapter 3; eight siblings are a block of its 3.4.3
/// Reading is const and may go on in several threads at once.
class HashedOctree {
public:
    /// Numbers of cells and nodes; they stay until the cell or node is removed, and then may be
    /// given to another. Without removals those of nodes are 0, 1, 2, …; those of cells have gaps:
    /// a cell's number is where `links` keeps its first corner.
    using CellNumber = std::uint32_t;
    using NodeNumber = std::uint32_t;

    /// Writes what the node at a position holds.
    using NodeSampler = std::function<void(const Index3& position, std::span<float> out)>;

    /// One cell, the root, its corners sampled.
    /// throws  InputError unless 0 <= depth <= greatest_octree_depth
    HashedOctree(int depth, OctreeFilter filter, const NodeSampler& sampler);

    int depth() const { return depth_; }
    OctreeFilter filter() const { return filter_; }
    OctreeCell root() const { return {Index3::Zero(), depth_}; }
    std::size_t cell_count() const { return 1 + 8 * table_.size(); }
    std::size_t leaf_count() const { return 1 + 7 * table_.size(); }
    std::size_t node_count() const;
    /// Of all arrays; and of the table alone, which is all that tells which cells there are.
    std::size_t memory_bytes() const;
    std::size_t table_bytes() const { return table_.memory_bytes(); }

    // Cells: one probe of the table, whatever the depth. In line: what callers read of the result
    // need not go through memory.

    /// All numbers of cells are below this.
    std::size_t cell_number_end() const { return links_.size(); }
    /// Nothing if there is no such cell.
    std::optional<CellNumber> find(const OctreeCell& cell) const {
        if (!is_in_range(cell)) return std::nullopt;
        if (cell.level == depth_) return 0;
        const OctreeTable::Entry* siblings = table_.find(key_of(cell.position, cell.level + 1));
        if (!siblings) return std::nullopt;
        return siblings->links + link_offset(child_index(cell.position, cell.level));
    }
    bool is_divided(const OctreeCell& cell) const;
    /// The leaf that holds a point, by binary search over levels (3.3.1). On a face between cells
    /// the one above; points outside belong to the nearest cell inside.
    OctreeCell leaf_at(const Vec3d& p_index) const { return find_leaf(p_index).cell; }
    struct Found {
        OctreeCell cell;
        CellNumber number;
        bool operator==(const Found&) const = default;
    };
    /// The same with its number.
    Found find_leaf(const Vec3d& p_index) const;
    /// The smallest cell of at least this one's size that touches its face, upwards or downwards
    /// along `axis`; nothing at the border (3.3.2).
    std::optional<OctreeCell> neighbour(const OctreeCell& cell, int axis, bool upwards) const;

    // Nodes.

    /// Of a cell's corners, as in CornerData; and of the i-th alone.
    std::array<NodeNumber, 8> nodes_of(CellNumber cell) const;
    NodeNumber node_of(CellNumber cell, unsigned i) const { return links_[cell + link_offset(i)]; }
    /// Of the 27 corners of a divided cell's children, x fastest; until the tree changes.
    std::span<const NodeNumber> nodes_within(const OctreeCell& divided) const {
        return block_of(*entry_of(divided));
    }
    /// What a cell's corners hold; until the tree changes.
    CornerData corners_of(CellNumber cell) const;
    /// The node at a position, through at most four cells that may have it (3.3.3).
    std::optional<NodeNumber> find_node(const Index3& position) const;
    std::span<const float> data_of(NodeNumber node) const {
        return {nodes_.data() + node * components_, components_};
    }
    std::span<float> data_of(NodeNumber node) {
        return {nodes_.data() + node * components_, components_};
    }
    /// True if there is a node at the position that a leaf has on an edge or a face and not as a
    /// corner.
    bool is_hanging(const Index3& position) const;
    /// True if the node's data is what constrain_hanging_nodes put there.
    bool is_constrained(NodeNumber node) const { return constrained_[node]; }

    /// The field at a point; continuous once hanging nodes are constrained.
    float value_at(const Vec3d& p_index) const { return value_at(p_index, find_leaf(p_index)); }
    /// The same where the leaf is known.
    float value_at(const Vec3d& p_index, const Found& leaf) const;

    // Changes.

    /// Divides a leaf; the sampler is asked for the nodes that are new, once each, x fastest. If it
    /// throws, nothing has changed.
    /// throws  InputError if there is no such leaf, or it has level 0
    void divide(const OctreeCell& leaf, const NodeSampler& sampler);
    /// Removes the children of a cell, all of them leaves, and the nodes that no other cell has.
    /// throws  InputError if there is no such cell, or it is a leaf, or a child is divided
    void merge(const OctreeCell& cell);
    /// Lets each hanging node hold what its coarser neighbour has there (3.4.1). Those that hung
    /// and no longer do are sampled again. HangingNodes does the same for a tree that grows.
    void constrain_hanging_nodes(const NodeSampler& sampler);
    /// Notes whether the node's data is constrained.
    void set_constrained(NodeNumber node, bool is) { constrained_[node] = is; }
    /// Room for so many divided cells without growing.
    void reserve(std::size_t divided_cells);

    /// Depth first, children in order: Morton's order of the leaves.
    /// visit  is called with each cell before its children
    void visit_cells(const std::function<void(const OctreeCell&, bool is_leaf)>& visit) const;
    /// Each node once: the root's corners, then those of the children of each divided cell, in
    /// visit_cells' order. It is the order in which dividing those cells makes them.
    void visit_nodes(const std::function<void(const Index3& position, NodeNumber)>& visit) const;

private:
    /// From a block's first link to that at the lower (0) or middle (1) x, y, z of bits 0, 1, 2.
    static constexpr unsigned link_offset(unsigned bits) {
        return (bits & 1) + 3 * (bits >> 1 & 1) + 9 * (bits >> 2);
    }
    std::span<NodeNumber> block_of(const OctreeTable::Entry& entry) {
        return std::span(links_).subspan(entry.links, 27);
    }
    std::span<const NodeNumber> block_of(const OctreeTable::Entry& entry) const {
        return std::span(links_).subspan(entry.links, 27);
    }

    /// True for a place and a size that the tree could have.
    bool is_in_range(const OctreeCell& cell) const {
        if (cell.level < 0 || cell.level > depth_) return false;
        const auto bits =
            static_cast<unsigned>(cell.position.x() | cell.position.y() | cell.position.z());
        return bits >> depth_ == 0 && (bits & (static_cast<unsigned>(cell.size()) - 1)) == 0;
    }
    const OctreeTable::Entry* entry_of(const OctreeCell& cell) const;
    Found smallest_cell_at(const Index3& position, int least_level) const;
    Index3 finest_cell_at(const Vec3d& p_index) const;
    struct Surroundings {
        std::optional<NodeNumber> node;
        int cells = 0;   // that have the position as the middle of an edge, a face or themselves
        int divided = 0; // of these
    };
    Surroundings surroundings_of(const Index3& position) const;
    NodeNumber add_node(std::span<const float> data);
    template<class Visit>
    void visit_blocks(const Visit& visit) const;

    int depth_ = 0;
    OctreeFilter filter_ = OctreeFilter::Linear;
    std::size_t components_ = 1;
    OctreeTable table_;
    std::vector<NodeNumber> links_; // the root's lie as if it were the lowest of eight siblings
    std::vector<float> nodes_;
    std::vector<bool> constrained_; // a bit a node
    // Numbers that were removed and not given again.
    std::vector<std::uint32_t> free_links_; // firsts of 27
    std::vector<NodeNumber> free_nodes_;
};

/// Leaves of points that lie close to the last one: the last leaf is tried first (3.4.2). Of points
/// half a finest cell apart along rays it holds 19 in 20. Another cursor for each thread, and a new
/// one after each change of the tree.
class OctreeCursor {
public:
    explicit OctreeCursor(const HashedOctree& tree)
        : tree_(&tree), leaf_(tree.find_leaf(Vec3d::Zero())) {}

    /// As of the tree.
    const HashedOctree::Found& find_leaf(const Vec3d& p_index) {
        const OctreeCell& cell = leaf_.cell;
        for (int axis = 0; axis < 3; ++axis) {
            const double t = p_index[axis] - cell.position[axis];
            if (!(t >= 0 && t < cell.size())) return leaf_ = tree_->find_leaf(p_index);
        }
        return leaf_;
    }
    float value_at(const Vec3d& p_index) { return tree_->value_at(p_index, find_leaf(p_index)); }

private:
    const HashedOctree* tree_;
    HashedOctree::Found leaf_;
};

} // namespace isocast
