// An octree without pointers.
// SPDX-License-Identifier: MPL-2.0
#include "volume/hashed_octree.h"

#include "volume/assert.h"
#include "volume/errors.h"
#include "volume/hanging_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

constexpr HashedOctree::NodeNumber no_node = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t root_links = 14; // to its last corner, of 27 of eight siblings

Index3 corner(unsigned i) {
    return {static_cast<int>(i & 1), static_cast<int>(i >> 1 & 1), static_cast<int>(i >> 2)};
}

/// Where a block keeps the node at `place` in {0, 1, 2}^3, in edges of the children.
std::size_t block_index(const Index3& place) {
    return static_cast<std::size_t>(place.x() + 3 * place.y() + 9 * place.z());
}

/// Calls visit(place) for lo <= place <= hi, x fastest.
template<class Visit>
void for_each_place(const Index3& lo, const Index3& hi, const Visit& visit) {
    Index3 place;
    for (place.z() = lo.z(); place.z() <= hi.z(); ++place.z())
        for (place.y() = lo.y(); place.y() <= hi.y(); ++place.y())
            for (place.x() = lo.x(); place.x() <= hi.x(); ++place.x()) visit(place);
}

/// The greatest level whose cells have corners there.
int alignment_of(const Index3& position) {
    return std::countr_zero(static_cast<unsigned>(position.x() | position.y() | position.z()));
}

std::string text_of(const OctreeCell& cell) {
    return fmt::format("cell ({}, {}, {}) of level {}", cell.position.x(), cell.position.y(),
                       cell.position.z(), cell.level);
}

} // namespace

HashedOctree::HashedOctree(int depth, OctreeFilter filter, const NodeSampler& sampler)
    : depth_(depth), filter_(filter), components_(static_cast<std::size_t>(components_of(filter))) {
    if (depth < 0 || depth > greatest_octree_depth)
        throw InputError(fmt::format("an octree's depth must be 0 to {}, and is {}",
                                     greatest_octree_depth, depth));
    links_.resize(root_links);
    std::array<float, 8> data{};
    for (unsigned i = 0; i < 8; ++i) {
        sampler(corner(i) * root().size(), std::span(data).first(components_));
        links_[link_offset(i)] = add_node(std::span(data).first(components_));
    }
}

std::size_t HashedOctree::node_count() const {
    return nodes_.size() / components_ - free_nodes_.size();
}

std::size_t HashedOctree::memory_bytes() const {
    return table_.memory_bytes() + links_.capacity() * sizeof(NodeNumber) +
           nodes_.capacity() * sizeof(float) + constrained_.capacity() / 8 +
           free_links_.capacity() * sizeof(std::uint32_t) +
           free_nodes_.capacity() * sizeof(NodeNumber);
}

/// Of a cell that is in range; null unless it is there and divided.
const OctreeTable::Entry* HashedOctree::entry_of(const OctreeCell& cell) const {
    return cell.level == 0 ? nullptr : table_.find(key_of(cell));
}

bool HashedOctree::is_divided(const OctreeCell& cell) const {
    return is_in_range(cell) && entry_of(cell);
}

/// The finest cell, there or not, that holds a point, or of those inside the one nearest to it.
Index3 HashedOctree::finest_cell_at(const Vec3d& p_index) const {
    const double last = root().size() - 1;
    // In this order not-a-number becomes 0.
    return p_index.unaryExpr([&](double x) { return std::max(0.0, std::min(x, last)); })
        .cast<int>();
}

/// The cell of the least level >= least_level that holds a finest cell, by binary search over
/// levels: above a divided cell all are divided.
HashedOctree::Found HashedOctree::smallest_cell_at(const Index3& position, int least_level) const {
    int level = depth_;
    CellNumber number = 0;
    int low = least_level + 1; // the least divided level lies in [low, high], if there is one
    int high = depth_;
    while (low <= high) {
        const int middle = (low + high) / 2;
        const OctreeTable::Entry* entry = table_.find(key_of(position, middle));
        if (!entry) {
            low = middle + 1;
            continue;
        }
        level = middle - 1;
        const unsigned child = child_index(position, level);
        number = entry->links + link_offset(child);
        if (!(entry->divided >> child & 1)) break;
        high = level;
    }
    return {cell_around(position, level), number};
}

HashedOctree::Found HashedOctree::find_leaf(const Vec3d& p_index) const {
    return smallest_cell_at(finest_cell_at(p_index), 0);
}

std::optional<OctreeCell> HashedOctree::neighbour(const OctreeCell& cell, int axis,
                                                  bool upwards) const {
    OctreeCell beside = cell;
    beside.position[axis] += upwards ? cell.size() : -cell.size();
    if (!is_in_range(beside)) return std::nullopt;
    return smallest_cell_at(beside.position, cell.level).cell;
}

std::array<HashedOctree::NodeNumber, 8> HashedOctree::nodes_of(CellNumber cell) const {
    std::array<NodeNumber, 8> nodes;
    for (unsigned i = 0; i < 8; ++i) nodes[i] = node_of(cell, i);
    return nodes;
}

CornerData HashedOctree::corners_of(CellNumber cell) const {
    CornerData corners;
    for (unsigned i = 0; i < 8; ++i) corners[i] = data_of(node_of(cell, i)).data();
    return corners;
}

/// A node was made by dividing a cell of the level above its alignment that has the node in its
/// middle, on a face or inside an edge: of those there are one, two or four.
HashedOctree::Surroundings HashedOctree::surroundings_of(const Index3& position) const {
    Surroundings result;
    const int level = alignment_of(position) + 1;
    const auto on_axis = [&](int i) { return (i & ((1 << level) - 1)) == 0; };
    const Index3 inside = position.unaryExpr([&](int i) { return on_axis(i) ? 0 : 1; });
    // On an axis where it is inside, the cell's lower end is half an edge down; on another the cell
    // is the one below or the one above.
    for_each_place(inside - Index3::Ones(), Index3::Zero(), [&](const Index3& step) {
        const OctreeCell cell = {position + step * (1 << level) - inside * (1 << (level - 1)),
                                 level};
        if (!is_in_range(cell)) return;
        ++result.cells;
        const OctreeTable::Entry* entry = entry_of(cell);
        if (!entry) return;
        ++result.divided;
        result.node = block_of(*entry)[block_index(inside - 2 * step)];
    });
    return result;
}

std::optional<HashedOctree::NodeNumber> HashedOctree::find_node(const Index3& position) const {
    if ((position.array() < 0).any() || (position.array() > root().size()).any())
        return std::nullopt;
    if (alignment_of(position) >= depth_) return child_index(position, depth_);
    return surroundings_of(position).node;
}

bool HashedOctree::is_hanging(const Index3& position) const {
    if (alignment_of(position) >= depth_) return false; // a corner of the root
    const Surroundings around = surroundings_of(position);
    return around.node && around.divided < around.cells;
}

float HashedOctree::value_at(const Vec3d& p_index, const Found& leaf) const {
    const double size = leaf.cell.size();
    const Vec3d t = (p_index - leaf.cell.position.cast<double>()) / size;
    return interpolate(filter_, corners_of(leaf.number), size, t.cwiseMax(0).cwiseMin(1));
}

HashedOctree::NodeNumber HashedOctree::add_node(std::span<const float> data) {
    if (!free_nodes_.empty()) {
        const NodeNumber node = free_nodes_.back();
        free_nodes_.pop_back();
        std::ranges::copy(data, data_of(node).begin());
        return node;
    }
    const std::size_t node = constrained_.size();
    if (node >= no_node) throw ResourceError("an octree holds no more than 2^32 - 1 nodes");
    nodes_.insert(nodes_.end(), data.begin(), data.end());
    constrained_.push_back(false);
    return static_cast<NodeNumber>(node);
}

void HashedOctree::divide(const OctreeCell& leaf, const NodeSampler& sampler) {
    const std::optional<CellNumber> number = find(leaf);
    if (!number || leaf.level == 0 || entry_of(leaf))
        throw InputError(fmt::format("cannot divide {}: {}", text_of(leaf),
                                     !number           ? "there is none"
                                     : leaf.level == 0 ? "it is of the finest"
                                                       : "it is no leaf"));
    if (free_links_.empty() && links_.size() > no_node - 27)
        throw ResourceError("an octree links no more than 2^32 corners");

    std::array<NodeNumber, 27> block;
    block.fill(no_node);
    const std::array<NodeNumber, 8> corners = nodes_of(*number);
    for (unsigned i = 0; i < 8; ++i) block[block_index(2 * corner(i))] = corners[i];
    // Of those between corners, the ones that divided neighbours of the same size have.
    for_each_place(-Index3::Ones(), Index3::Ones(), [&](const Index3& step) {
        const int axes = step.cwiseAbs().sum();
        const OctreeCell beside = {leaf.position + step * leaf.size(), leaf.level};
        if (axes == 0 || axes == 3 || !is_in_range(beside)) return;
        const OctreeTable::Entry* entry = entry_of(beside);
        if (!entry) return;
        const std::span<const NodeNumber> other = block_of(*entry);
        const Index3 lo = step.unaryExpr([](int s) { return s > 0 ? 2 : 0; });
        const Index3 hi = step.unaryExpr([](int s) { return s < 0 ? 0 : 2; });
        for_each_place(lo, hi, [&](const Index3& place) {
            block[block_index(place)] = other[block_index(place - 2 * step)];
        });
    });

    // At most 19 are new. All are sampled before anything changes.
    std::array<float, 19 * 8> data{};
    const auto data_of_new = [&](std::size_t i) {
        return std::span(data).subspan(i * components_, components_);
    };
    std::size_t count = 0;
    for_each_place(Index3::Zero(), Index3::Constant(2), [&](const Index3& place) {
        if (block[block_index(place)] == no_node)
            sampler(leaf.position + place * (leaf.size() / 2), data_of_new(count++));
    });
    count = 0;
    for (NodeNumber& node : block)
        if (node == no_node) node = add_node(data_of_new(count++));

    OctreeTable::Entry entry = {.key = key_of(leaf)};
    if (free_links_.empty()) {
        entry.links = static_cast<std::uint32_t>(links_.size());
        links_.insert(links_.end(), block.begin(), block.end());
    } else {
        entry.links = free_links_.back();
        free_links_.pop_back();
        std::ranges::copy(block, block_of(entry).begin());
    }
    table_.insert(entry);
    if (leaf.level < depth_)
        table_.find(key_of(leaf.position, leaf.level + 1))->divided |=
            static_cast<std::uint8_t>(1 << child_index(leaf.position, leaf.level));
}

void HashedOctree::merge(const OctreeCell& cell) {
    const OctreeTable::Entry* entry = is_in_range(cell) ? entry_of(cell) : nullptr;
    if (!entry || entry->divided != 0)
        throw InputError(fmt::format("cannot merge the children of {}: {}", text_of(cell),
                                     entry ? "one of them is divided" : "it has none"));
    for_each_place(Index3::Zero(), Index3::Constant(2), [&](const Index3& place) {
        if ((place.array() != 1).all()) return; // a corner of the cell itself
        if (surroundings_of(cell.position + place * (cell.size() / 2)).divided > 1) return;
        const NodeNumber node = block_of(*entry)[block_index(place)];
        constrained_[node] = false;
        free_nodes_.push_back(node);
    });
    free_links_.push_back(entry->links);
    table_.erase(key_of(cell));
    if (cell.level < depth_)
        table_.find(key_of(cell.position, cell.level + 1))->divided &=
            static_cast<std::uint8_t>(~(1 << child_index(cell.position, cell.level)));
}

void HashedOctree::constrain_hanging_nodes(const NodeSampler& sampler) {
    HangingNodes hanging;
    visit_blocks(
        [&](const OctreeCell& cell, const OctreeTable::Entry&) { hanging.add(*this, cell); });
    hanging.constrain(*this, sampler, [](const Index3&) {});
}

void HashedOctree::reserve(std::size_t divided_cells) {
    table_.reserve(divided_cells);
    links_.reserve(root_links + 27 * divided_cells);
}

/// Calls visit(cell, entry) for each divided cell, depth first.
template<class Visit>
void HashedOctree::visit_blocks(const Visit& visit) const {
    const auto descend = [&](const auto& self, const OctreeCell& cell) -> void {
        const OctreeTable::Entry& entry = *entry_of(cell);
        visit(cell, entry);
        for (int i = 0; i < 8; ++i)
            if (entry.divided >> i & 1) self(self, child_of(cell, i));
    };
    if (entry_of(root())) descend(descend, root());
}

void HashedOctree::visit_cells(
    const std::function<void(const OctreeCell&, bool is_leaf)>& visit) const {
    const auto descend = [&](const auto& self, const OctreeCell& cell, bool is_leaf) -> void {
        visit(cell, is_leaf);
        if (is_leaf) return;
        const std::uint8_t divided = entry_of(cell)->divided;
        for (int i = 0; i < 8; ++i) self(self, child_of(cell, i), !(divided >> i & 1));
    };
    descend(descend, root(), !entry_of(root()));
}

void HashedOctree::visit_nodes(
    const std::function<void(const Index3& position, NodeNumber)>& visit) const {
    std::vector<bool> is_visited(constrained_.size());
    for (unsigned i = 0; i < 8; ++i) {
        visit(corner(i) * root().size(), i);
        is_visited[i] = true;
    }
    visit_blocks([&](const OctreeCell& cell, const OctreeTable::Entry& entry) {
        for_each_place(Index3::Zero(), Index3::Constant(2), [&](const Index3& place) {
            const NodeNumber node = block_of(entry)[block_index(place)];
            if (is_visited[node]) return;
            is_visited[node] = true;
            visit(cell.position + place * (cell.size() / 2), node);
        });
    });
}

} // namespace isocast
