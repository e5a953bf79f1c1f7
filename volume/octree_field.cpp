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

CornerData corners_of(const HashedOctree& tree, const OctreeCell& cell) {
    CornerData corners;
    const auto nodes = tree.nodes_of(*tree.find(cell));
    for (std::size_t i = 0; i < 8; ++i) corners[i] = tree.data_of(nodes[i]).data();
    return corners;
}

/// The samples of a cell: those at its faces belong to the cell above, or to it at the border.
IndexBox samples_of(const OctreeCell& cell, int depth) {
    const Index3 end = (cell.position.array() + cell.size()).matrix();
    const Index3 is_border = (end.array() == 1 << depth).cast<int>().matrix();
    return {cell.position, end + is_border};
}

/// Calls at_leaf(cell) for the leaves under `cell` that hold a sample of `box`.
template<class AtLeaf>
void visit_leaves(const HashedOctree& tree, const OctreeCell& cell, const IndexBox& box,
                  const AtLeaf& at_leaf) {
    if (intersection(samples_of(cell, tree.depth()), box).is_empty()) return;
    if (!tree.is_divided(cell)) {
        at_leaf(cell);
        return;
    }
    for (int i = 0; i < 8; ++i) visit_leaves(tree, child_of(cell, i), box, at_leaf);
}

/// ceil(index / 2^level)
Index3 ceil_shift(const Index3& index, int level) {
    return -floor_div(-index, 1 << level);
}

} // namespace

OctreeField::OctreeField(HashedOctree tree, GridSpace space, double half_width_world)
    : tree_(std::move(tree)), space_(std::move(space)), half_width_world_(half_width_world) {
    if (!(half_width_world > 0) || !std::isfinite(half_width_world))
        throw InputError(fmt::format("a half width of {} is not a length", half_width_world));
}

IndexBox OctreeField::extent() const {
    return samples_of(tree_.root(), tree_.depth());
}

std::vector<IndexBox> OctreeField::active_boxes() const {
    // No smaller than blocks: what is smaller would only be put together again.
    constexpr int block_level = std::countr_zero(static_cast<unsigned>(block_size));
    std::vector<IndexBox> boxes;
    const auto is_active = [&](const OctreeCell& cell) {
        const CellBounds bounds = bounds_of(tree_.filter(), corners_of(tree_, cell), cell.size());
        return bounds.min < half_width_world_ && bounds.max > -half_width_world_;
    };
    std::optional<OctreeCell> taken; // the last small cell that was listed
    tree_.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
        if (!is_leaf) return;
        OctreeCell block = cell;
        while (block.level < std::min(block_level, tree_.depth())) block = parent_of(block);
        if ((taken && *taken == block) || !is_active(cell)) return;
        taken = block;
        boxes.push_back(samples_of(block, tree_.depth()));
    });
    return boxes;
}

int OctreeField::finest_level(const IndexBox& box) const {
    int finest = tree_.depth();
    visit_leaves(tree_, tree_.root(), box,
                 [&](const OctreeCell& leaf) { finest = std::min(finest, leaf.level); });
    return finest;
}

ValueRange OctreeField::value_range(const IndexBox& box) const {
    const auto background = static_cast<float>(half_width_world_);
    ValueRange range{background, -background};
    visit_leaves(tree_, tree_.root(), box, [&](const OctreeCell& leaf) {
        const CellBounds bounds = bounds_of(tree_.filter(), corners_of(tree_, leaf), leaf.size());
        range.min = std::min(range.min, static_cast<float>(bounds.min));
        range.max = std::max(range.max, static_cast<float>(bounds.max));
    });
    const IndexBox inside = intersection(box, extent());
    if (inside != box) range = {-background, background};
    return {std::clamp(range.min, -background, background),
            std::clamp(range.max, -background, background)};
}

void OctreeField::copy_box(const IndexBox& box, int level, std::span<float> out) const {
    const auto background = static_cast<float>(half_width_world_);
    const IndexBox all = extent();
    const Index3 n = box.size();
    const auto place = [&](int x, int y, int z) -> float& {
        return out[static_cast<std::size_t>(
            (x - box.lo.x()) +
            std::ptrdiff_t{n.x()} * ((y - box.lo.y()) + std::ptrdiff_t{n.y()} * (z - box.lo.z())))];
    };
    const int step = 1 << level;
    const IndexBox read{step * box.lo, (step * (box.hi.array() - 1) + 1).matrix()};
    const auto fill = [&](const auto& self, const OctreeCell& cell) -> void {
        // The lattice's samples in the cell.
        const IndexBox own = samples_of(cell, tree_.depth());
        const IndexBox part =
            intersection({ceil_shift(own.lo, level), ceil_shift(own.hi, level)}, box);
        if (part.is_empty()) return;
        if (tree_.is_divided(cell)) {
            for (int i = 0; i < 8; ++i) self(self, child_of(cell, i));
            return;
        }
        const CornerData corners = corners_of(tree_, cell);
        const double size = cell.size();
        for (int z = part.lo.z(); z < part.hi.z(); ++z)
            for (int y = part.lo.y(); y < part.hi.y(); ++y)
                for (int x = part.lo.x(); x < part.hi.x(); ++x) {
                    const Vec3d t = (step * Index3(x, y, z) - cell.position).cast<double>() / size;
                    place(x, y, z) = std::clamp(interpolate(tree_.filter(), corners, size, t),
                                                -background, background);
                }
    };
    fill(fill, tree_.root());
    if (intersection(read, all) == read) return;
    // Beyond the extent a sample has the sign of the border.
    for (int z = box.lo.z(); z < box.hi.z(); ++z)
        for (int y = box.lo.y(); y < box.hi.y(); ++y)
            for (int x = box.lo.x(); x < box.hi.x(); ++x) {
                const Index3 index = step * Index3(x, y, z);
                if (all.contains(index)) continue;
                const Index3 border =
                    index.cwiseMax(all.lo).cwiseMin((all.hi.array() - 1).matrix());
                place(x, y, z) = std::copysign(background, tree_.value_at(border.cast<double>()));
            }
}

} // namespace isocast
