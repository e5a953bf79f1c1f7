// An octree as a field source: samples at any level, without a dense grid.
// SPDX-License-Identifier: MPL-2.0
#include "volume/octree_field.h"

#include "volume/cell_bounds.h"
#include "volume/errors.h"
#include "volume/sparse_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace isocast {

namespace {

/// Levels between a block and its cells.
constexpr int block_levels = std::countr_zero(static_cast<unsigned>(block_size));
/// Levels that one field shows: a block's cells may be as large as the block.
constexpr int levels_of_field = block_levels + 1;

CellBounds bounds_of_leaf(const HashedOctree& tree, const OctreeCell& leaf) {
    return bounds_of(tree.filter(), tree.corners_of(*tree.find(leaf)), leaf.size());
}

/// The finest cells' corners in a cell: those at its faces belong to the cell above, or to it at
/// the border.
IndexBox corners_in(const OctreeCell& cell, int depth) {
    const Index3 end = (cell.position.array() + cell.size()).matrix();
    const Index3 is_border = (end.array() == 1 << depth).cast<int>().matrix();
    return {cell.position, end + is_border};
}

/// ceil(index / 2^level)
Index3 ceil_shift(const Index3& index, int level) {
    return -floor_div(-index, 1 << level);
}

bool is_before(const OctreeCell& a, const OctreeCell& b) {
    return zyx_less(a.position, b.position);
}

GridSpace lattice_space(GridSpace space, int lattice) {
    space.world_from_index.scale(std::exp2(lattice));
    return space;
}

} // namespace

OctreeField::OctreeField(std::shared_ptr<const HashedOctree> tree, const GridSpace& space,
                         double reach_world, int lattice)
    : tree_(std::move(tree)), space_(lattice_space(space, lattice)), reach_world_(reach_world),
      lattice_(lattice) {
    if (!(reach_world >= 0) || !std::isfinite(reach_world))
        throw InputError(fmt::format("a reach of {} is not a length", reach_world));
    if (lattice < 0 || lattice > tree_->depth())
        throw InputError(
            fmt::format("an octree of depth {} has no cells of level {}", tree_->depth(), lattice));
}

IndexBox OctreeField::extent() const {
    const int across = 1 << (tree_->depth() - lattice_);
    return {Index3::Zero(), Index3::Constant(across + 1)};
}

bool OctreeField::is_in_reach(const OctreeCell& leaf) const {
    const CellBounds bounds = bounds_of_leaf(*tree_, leaf);
    return bounds.min <= reach_world_ && bounds.max >= -reach_world_;
}

int OctreeField::finest_leaf(const OctreeCell& cell) const {
    if (!tree_->is_divided(cell)) {
        const OctreeCell leaf = tree_->leaf_at(cell.position.cast<double>()); // it or around it
        return is_in_reach(leaf) ? leaf.level : greatest_octree_depth;
    }
    int finest = greatest_octree_depth;
    for (int i = 0; i < 8 && finest > 0; ++i)
        finest = std::min(finest, finest_leaf(child_of(cell, i)));
    return finest;
}

template<class AtLeaf>
void OctreeField::visit_leaves(const OctreeCell& cell, const IndexBox& box, int level,
                               const AtLeaf& at_leaf) const {
    const IndexBox own = corners_in(cell, tree_->depth());
    const IndexBox part = intersection({ceil_shift(own.lo, level), ceil_shift(own.hi, level)}, box);
    if (part.is_empty()) return;
    if (!tree_->is_divided(cell)) {
        at_leaf(cell, part);
        return;
    }
    for (int i = 0; i < 8; ++i) visit_leaves(child_of(cell, i), box, level, at_leaf);
}

IndexBox OctreeField::finest_box(const IndexBox& box) const {
    if (box.is_empty()) return {};
    const int step = 1 << lattice_;
    return {step * box.lo, (step * (box.hi.array() - 1) + 1).matrix()};
}

std::vector<IndexBox> OctreeField::active_boxes() const {
    const auto samples_in = [&](const OctreeCell& cell) {
        const IndexBox corners = corners_in(cell, tree_->depth());
        return IndexBox{ceil_shift(corners.lo, lattice_), ceil_shift(corners.hi, lattice_)};
    };
    std::vector<IndexBox> boxes;
    if (blocks_) {
        for (const OctreeCell& block : *blocks_) boxes.push_back(samples_in(block));
        return boxes;
    }
    const int level = std::min(lattice_ + block_levels, tree_->depth());
    const auto add = [&](const auto& self, const OctreeCell& cell) -> void {
        if (cell.level <= level || !tree_->is_divided(cell)) {
            if (finest_leaf(cell) < greatest_octree_depth) boxes.push_back(samples_in(cell));
            return;
        }
        for (int i = 0; i < 8; ++i) self(self, child_of(cell, i));
    };
    add(add, tree_->root());
    return boxes;
}

int OctreeField::finest_level(const IndexBox& box) const {
    if (blocks_) {
        const Index3 block = floor_div(box.lo, block_size);
        const OctreeCell cell{block * (block_size << lattice_), lattice_ + block_levels};
        if (!std::ranges::binary_search(*blocks_, cell, is_before)) return -1;
    }
    int finest = greatest_octree_depth;
    visit_leaves(tree_->root(), finest_box(box), 0, [&](const OctreeCell& leaf, const IndexBox&) {
        if (leaf.level < finest && is_in_reach(leaf)) finest = leaf.level;
    });
    return std::max(finest - lattice_, 0);
}

ValueRange OctreeField::value_range(const IndexBox& box) const {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const IndexBox all = extent();
    const Index3 last = (all.hi.array() - 1).matrix();
    // Beyond the extent the samples at the border continue.
    const IndexBox inside{
        box.lo.cwiseMax(all.lo).cwiseMin(last),
        ((box.hi.array() - 1).matrix().cwiseMax(all.lo).cwiseMin(last).array() + 1).matrix()};
    ValueRange range{infinity, -infinity};
    visit_leaves(tree_->root(), inside, lattice_, [&](const OctreeCell& leaf, const IndexBox&) {
        const CellBounds bounds = bounds_of_leaf(*tree_, leaf);
        range.min = std::min(range.min, std::nextafter(static_cast<float>(bounds.min), -infinity));
        range.max = std::max(range.max, std::nextafter(static_cast<float>(bounds.max), infinity));
    });
    return range;
}

void OctreeField::copy_box(const IndexBox& box, int level, std::span<float> out) const {
    const int shift = lattice_ + level; // of the box's lattice, from the finest cells'
    const Index3 n = box.size();
    const auto place = [&](int x, int y, int z) -> float& {
        return out[static_cast<std::size_t>(
            (x - box.lo.x()) +
            std::ptrdiff_t{n.x()} * ((y - box.lo.y()) + std::ptrdiff_t{n.y()} * (z - box.lo.z())))];
    };
    visit_leaves(tree_->root(), box, shift, [&](const OctreeCell& leaf, const IndexBox& part) {
        const CornerData corners = tree_->corners_of(*tree_->find(leaf));
        const double size = leaf.size();
        const bool is_linear = tree_->filter() == OctreeFilter::Linear;
        const double step = std::exp2(shift) / size;
        const Vec3d first = ((1 << shift) * part.lo - leaf.position).cast<double>() / size;
        for (int z = part.lo.z(); z < part.hi.z(); ++z)
            for (int y = part.lo.y(); y < part.hi.y(); ++y) {
                const CellRow row =
                    row_of(tree_->filter(), corners, size, first.y() + step * (y - part.lo.y()),
                           first.z() + step * (z - part.lo.z()));
                float* const to = &place(part.lo.x(), y, z);
                for (int i = 0; i < part.hi.x() - part.lo.x(); ++i) {
                    const double x = first.x() + step * i; // exact: all are multiples of 1 / size
                    to[i] = is_linear ? row.linear_at(x) : row.cubic_at(x);
                }
            }
    });
    // Of a lattice of larger cells than the root it holds sample 0 alone.
    const int last = tree_->depth() >= shift ? 1 << (tree_->depth() - shift) : 0;
    const IndexBox all{Index3::Zero(), Index3::Constant(last + 1)};
    if (intersection(box, all) == box) return;
    // Beyond the extent the samples at the border continue.
    for (int z = box.lo.z(); z < box.hi.z(); ++z)
        for (int y = box.lo.y(); y < box.hi.y(); ++y)
            for (int x = box.lo.x(); x < box.hi.x(); ++x)
                if (!all.contains({x, y, z}))
                    place(x, y, z) = tree_->value_at((1 << shift) * Vec3d(x, y, z));
}

std::vector<std::shared_ptr<const OctreeField>>
fields_of_octree(std::shared_ptr<const HashedOctree> tree, const GridSpace& space,
                 double reach_world, std::size_t greatest_block_count) {
    const OctreeField finest(tree, space, reach_world);
    const int least = finest.finest_leaf(tree->root());
    const int lattice = least < greatest_octree_depth ? least : 0;
    auto one = std::make_shared<const OctreeField>(tree, space, reach_world, lattice);
    if (lattice + levels_of_field > tree->depth() ||
        one->active_boxes().size() <= greatest_block_count)
        return {one};
    std::vector<std::shared_ptr<OctreeField>> fields;
    for (int l = lattice; l + block_levels <= tree->depth(); l += levels_of_field) {
        fields.push_back(std::make_shared<OctreeField>(tree, space, reach_world, l));
        fields.back()->blocks_.emplace();
    }
    const auto assign = [&](const auto& self, const OctreeCell& cell) -> void {
        const int detail = finest.finest_leaf(cell);
        if (detail == greatest_octree_depth) return;
        const int above = cell.level - block_levels - lattice;
        if (above >= 0 && above % levels_of_field == 0) {
            OctreeField& field = *fields[static_cast<std::size_t>(above / levels_of_field)];
            if (detail >= field.lattice_) {
                field.blocks_->push_back(cell);
                return;
            }
        }
        for (int i = 0; i < 8; ++i) self(self, child_of(cell, i));
    };
    assign(assign, tree->root());
    std::vector<std::shared_ptr<const OctreeField>> shown;
    for (const std::shared_ptr<OctreeField>& field : fields) {
        std::ranges::sort(*field->blocks_, is_before);
        if (!field->blocks_->empty()) shown.push_back(field);
    }
    return shown;
}

} // namespace isocast
