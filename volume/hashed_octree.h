// An octree without pointers: a hash table finds eight sibling cells by place and size.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/octree_interpolant.h"
#include "volume/octree_table.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace isocast {

/// Depths that an octree may have: cells of 2^0 … 2^20 finest cells.
inline constexpr int greatest_octree_depth = 20;

/// A cube of 2^level finest cells an edge; its lowest corner, a multiple of that, is `position`.
struct OctreeCell {
    Index3 position = Index3::Zero();
    int level = 0;

    int size() const { return 1 << level; }
    bool operator==(const OctreeCell&) const = default;
};

/// The cell's parent, and its i-th child: at the upper half of x if bit 0 of i is set, …
OctreeCell parent_of(const OctreeCell& cell);
OctreeCell child_of(const OctreeCell& cell, int i);

/// Cells over [0, 2^depth]^3, each of which may be divided into eight, and values at their corners
/// (nodes), which up to eight cells share.
///
/// Siblings are born and die together, so that one entry of the table stands for eight cells:
///
///     table   place and size of a divided cell ─► its block, and which children are divided
///     block   the numbers of the 27 corners of eight siblings, x fastest
///     nodes   components_of(filter) floats each
///
/// source  Sigg 2006 (thesis), chapter 3; blocks are its 3.4.3. The thesis has one entry a cell
/// Reading is const and may go on in several threads at once.
class HashedOctree {
public:
    /// Numbers of cells and nodes; they stay until the cell or node is removed, and then may be
    /// given to another. Without removals they are 0, 1, 2, … without gaps.
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

    // Cells: one probe of the table, whatever the depth.

    /// Nothing if there is no such cell.
    std::optional<CellNumber> find(const OctreeCell& cell) const;
    bool is_divided(const OctreeCell& cell) const;
    /// The leaf that holds a point, by binary search over levels (3.3.1). On a face between cells
    /// the one above; points outside belong to the nearest cell inside.
    OctreeCell leaf_at(const Vec3d& p_index) const;
    /// The smallest cell of at least this one's size that touches its face, upwards or downwards
    /// along `axis`; nothing at the border (3.3.2).
    std::optional<OctreeCell> neighbour(const OctreeCell& cell, int axis, bool upwards) const;

    // Nodes.

    /// Of a cell's corners, as in CornerData.
    std::array<NodeNumber, 8> nodes_of(CellNumber cell) const;
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
    float value_at(const Vec3d& p_index) const;

    // Changes.

    /// Divides a leaf; the sampler is asked for the nodes that are new, once each, x fastest. If it
    /// throws, nothing has changed.
    /// throws  InputError if there is no such leaf, or it has level 0
    void divide(const OctreeCell& leaf, const NodeSampler& sampler);
    /// Removes the children of a cell, all of them leaves, and the nodes that no other cell has.
    /// throws  InputError if there is no such cell, or it is a leaf, or a child is divided
    void merge(const OctreeCell& cell);
    /// Lets each hanging node hold what its coarser neighbour has there (3.4.1), coarse ones first.
    /// Those that hung and no longer do are sampled again.
    void constrain_hanging_nodes(const NodeSampler& sampler);
    /// Notes that the node's data is constrained; for a tree that is read from a file.
    void mark_constrained(NodeNumber node) { constrained_[node] = true; }
    /// Room for so many divided cells without growing.
    void reserve(std::size_t divided_cells);

    /// Depth first, children in order: Morton's order of the leaves.
    /// visit  is called with each cell before its children
    void visit_cells(const std::function<void(const OctreeCell&, bool is_leaf)>& visit) const;
    /// Each node once: the root's corners, then those of the children of each divided cell, in
    /// visit_cells' order. It is the order in which dividing those cells makes them.
    void visit_nodes(const std::function<void(const Index3& position, NodeNumber)>& visit) const;

private:
    using Block = std::array<NodeNumber, 27>;

    bool is_in_range(const OctreeCell& cell) const;
    const OctreeTable::Entry* entry_of(const OctreeCell& cell) const;
    struct Found {
        OctreeCell cell;
        CellNumber number;
    };
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
    std::vector<Block> blocks_;
    std::vector<float> nodes_;
    std::vector<bool> constrained_; // a bit a node
    // Numbers that were removed and not given again.
    std::vector<std::uint32_t> free_blocks_;
    std::vector<NodeNumber> free_nodes_;
};

} // namespace isocast
