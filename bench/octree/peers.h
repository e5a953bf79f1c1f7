// Other ways to keep an octree's cells, for table 3.1: linked and hashed, cells one by one and by
// eight. Each is made by giving it divided cells, parents first, and answers what the table asks.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/hashed_octree.h"

#include <array>
#include <span>
#include <vector>

namespace isocast {

using CornerNodes = std::array<std::uint32_t, 8>;
inline constexpr std::uint32_t nothing = 0xffffffff;

/// The thesis's linked tree (3.2): nine links a cell, of 32 bits.
class LinkedTree {
public:
    static constexpr const char* name = "linked, 9 links";

    LinkedTree(int depth, const CornerNodes& nodes) : depth_(depth) {
        cells_.push_back({.nodes = nodes});
        cells_[0].children.fill(nothing);
    }
    void divide(const OctreeCell& cell, std::span<const CornerNodes, 8> nodes) {
        const std::uint32_t parent = descend(cell.position, cell.level);
        for (unsigned i = 0; i < 8; ++i) {
            cells_[parent].children[i] = static_cast<std::uint32_t>(cells_.size());
            cells_.push_back({.parent = parent, .nodes = nodes[i]});
            cells_.back().children.fill(nothing);
        }
    }
    std::uint32_t node_of(const OctreeCell& cell) const {
        const std::uint32_t found = descend(cell.position, cell.level);
        return found == nothing ? nothing : cells_[found].nodes[0];
    }
    std::uint32_t leaf_node_at(const Index3& p) const {
        std::uint32_t cell = 0;
        for (int level = depth_ - 1; level >= 0; --level) {
            const std::uint32_t child = cells_[cell].children[child_index(p, level)];
            if (child == nothing) break;
            cell = child;
        }
        return cells_[cell].nodes[0];
    }
    std::size_t structure_bytes() const {
        return cells_.size() * (sizeof(Cell) - sizeof(CornerNodes));
    }

private:
    struct Cell {
        std::array<std::uint32_t, 8> children{};
        std::uint32_t parent = nothing;
        CornerNodes nodes{};
    };
    std::uint32_t descend(const Index3& p, int to_level) const {
        std::uint32_t cell = 0;
        for (int level = depth_ - 1; level >= to_level; --level) {
            cell = cells_[cell].children[child_index(p, level)];
            if (cell == nothing) return nothing;
        }
        return cell;
    }
    int depth_;
    std::vector<Cell> cells_;
};

/// A stronger one: one link to eight children that lie together, and none to the parent.
class LinkedBlocks {
public:
    static constexpr const char* name = "linked, 1 link";

    LinkedBlocks(int depth, const CornerNodes& nodes) : depth_(depth) {
        first_child_.push_back(nothing);
        nodes_.push_back(nodes);
    }
    void divide(const OctreeCell& cell, std::span<const CornerNodes, 8> nodes) {
        first_child_[descend(cell.position, cell.level)] =
            static_cast<std::uint32_t>(first_child_.size());
        first_child_.insert(first_child_.end(), 8, nothing);
        nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    }
    std::uint32_t node_of(const OctreeCell& cell) const {
        const std::uint32_t found = descend(cell.position, cell.level);
        return found == nothing ? nothing : nodes_[found][0];
    }
    std::uint32_t leaf_node_at(const Index3& p) const {
        std::uint32_t cell = 0;
        for (int level = depth_ - 1; level >= 0; --level) {
            const std::uint32_t first = first_child_[cell];
            if (first == nothing) break;
            cell = first + child_index(p, level);
        }
        return nodes_[cell][0];
    }
    std::size_t structure_bytes() const { return first_child_.size() * sizeof(std::uint32_t); }

private:
    std::uint32_t descend(const Index3& p, int to_level) const {
        std::uint32_t cell = 0;
        for (int level = depth_ - 1; level >= to_level; --level) {
            cell = first_child_[cell];
            if (cell == nothing) return nothing;
            cell += child_index(p, level);
        }
        return cell;
    }
    int depth_;
    std::vector<std::uint32_t> first_child_;
    std::vector<CornerNodes> nodes_;
};

/// Binary search over levels with `find(position, level)`, an index of a cell or nothing.
template<class Find>
std::uint32_t search_levels(int depth, const Find& find) {
    std::uint32_t found = nothing;
    int low = 0;
    int high = depth;
    while (low <= high) {
        const int middle = (low + high) / 2;
        const std::uint32_t cell = find(middle);
        if (cell == nothing) {
            low = middle + 1;
        } else {
            found = cell;
            high = middle - 1;
        }
    }
    return found;
}

/// The thesis's hashed tree (3.1 to 3.3): cells one by one, chained; the table grows by half when
/// it is filled to four fifths; the hash is of shifts, additions and exclusive ors.
class ChainedCells {
public:
    static constexpr const char* name = "hashed, chained cells";

    ChainedCells(int depth, const CornerNodes& nodes) : depth_(depth), heads_(16, nothing) {
        add({Index3::Zero(), depth}, nodes);
    }
    void divide(const OctreeCell& cell, std::span<const CornerNodes, 8> nodes) {
        for (int i = 0; i < 8; ++i) add(child_of(cell, i), nodes[static_cast<std::size_t>(i)]);
    }
    std::uint32_t node_of(const OctreeCell& cell) const {
        const std::uint32_t found = find(cell.position, cell.level);
        return found == nothing ? nothing : records_[found].nodes[0];
    }
    std::uint32_t leaf_node_at(const Index3& p) const {
        return records_[search_levels(depth_,
                                      [&](int level) { return find(aligned(p, level), level); })]
            .nodes[0];
    }
    std::size_t structure_bytes() const {
        return records_.size() * (sizeof(Record) - sizeof(CornerNodes)) +
               heads_.size() * sizeof(std::uint32_t);
    }

private:
    struct Record {
        int x, y, z;
        std::uint32_t level : 5, next : 27; // 13 bytes of key would take 16: these take 16 in all
        CornerNodes nodes;
    };
    static constexpr std::uint32_t last = (1u << 27) - 1;
    static Index3 aligned(const Index3& p, int level) {
        return p.unaryExpr([&](int i) { return i >> level << level; });
    }
    std::size_t head_of(int x, int y, int z, int level) const {
        auto hash = static_cast<std::uint32_t>(level);
        for (const int i : {x >> level, y >> level, z >> level}) {
            hash += static_cast<std::uint32_t>(i);
            hash += hash << 10;
            hash ^= hash >> 6;
        }
        hash += hash << 3;
        hash ^= hash >> 11;
        hash += hash << 15;
        return hash % static_cast<std::uint32_t>(heads_.size());
    }
    void add(const OctreeCell& cell, const CornerNodes& nodes) {
        if (records_.size() * 5 >= heads_.size() * 4) {
            heads_.assign(heads_.size() * 3 / 2, nothing);
            for (std::uint32_t i = 0; i < records_.size(); ++i) link(i);
        }
        const Index3& p = cell.position;
        records_.push_back(
            {p.x(), p.y(), p.z(), static_cast<std::uint32_t>(cell.level), last, nodes});
        link(static_cast<std::uint32_t>(records_.size() - 1));
    }
    void link(std::uint32_t i) {
        Record& record = records_[i];
        std::uint32_t& head =
            heads_[head_of(record.x, record.y, record.z, static_cast<int>(record.level))];
        record.next = head == nothing ? last : head & last;
        head = i;
    }
    std::uint32_t find(const Index3& p, int level) const {
        std::uint32_t i = heads_[head_of(p.x(), p.y(), p.z(), level)];
        if (i == nothing) return nothing;
        for (; i != last; i = records_[i].next) {
            const Record& r = records_[i];
            if (r.x == p.x() && r.y == p.y() && r.z == p.z() &&
                r.level == static_cast<unsigned>(level))
                return i;
        }
        return nothing;
    }
    int depth_;
    std::vector<std::uint32_t> heads_;
    std::vector<Record> records_;
};

/// As key_of, of cells of level 0 too.
inline std::uint64_t all_levels_key(const Index3& p, int level) {
    const auto field = [&](int axis) { return static_cast<std::uint64_t>(p[axis]) >> level; };
    return static_cast<std::uint64_t>(level + 1) << 59 | field(2) << 38 | field(1) << 19 | field(0);
}

/// Cells one by one, open-addressed as ours: key, number.
class OpenCells {
public:
    static constexpr const char* name = "hashed, open cells";

    OpenCells(int depth, const CornerNodes& nodes) : depth_(depth) {
        add({Index3::Zero(), depth}, nodes);
    }
    void divide(const OctreeCell& cell, std::span<const CornerNodes, 8> nodes) {
        for (int i = 0; i < 8; ++i) add(child_of(cell, i), nodes[static_cast<std::size_t>(i)]);
    }
    std::uint32_t node_of(const OctreeCell& cell) const {
        const OctreeTable::Entry* entry = table_.find(all_levels_key(cell.position, cell.level));
        return entry ? nodes_[entry->links][0] : nothing;
    }
    std::uint32_t leaf_node_at(const Index3& p) const {
        return nodes_[search_levels(depth_, [&](int level) {
            const OctreeTable::Entry* entry = table_.find(all_levels_key(p, level));
            return entry ? entry->links : nothing;
        })][0];
    }
    std::size_t structure_bytes() const { return table_.memory_bytes(); }

private:
    void add(const OctreeCell& cell, const CornerNodes& nodes) {
        table_.insert({.key = all_levels_key(cell.position, cell.level),
                       .links = static_cast<std::uint32_t>(nodes_.size())});
        nodes_.push_back(nodes);
    }
    int depth_;
    OctreeTable table_;
    std::vector<CornerNodes> nodes_;
};

/// Ours.
class Ours {
public:
    static constexpr const char* name = "ours";

    explicit Ours(const HashedOctree& tree) : tree_(tree) {}
    std::uint32_t node_of(const OctreeCell& cell) const {
        const auto number = tree_.find(cell);
        return number ? tree_.node_of(*number, 0) : nothing;
    }
    std::uint32_t leaf_node_at(const Index3& p) const {
        return tree_.node_of(tree_.find_leaf(p.cast<double>()).number, 0);
    }
    std::size_t structure_bytes() const { return tree_.table_bytes(); }

private:
    const HashedOctree& tree_;
};

} // namespace isocast
