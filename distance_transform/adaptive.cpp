// Adaptive distance fields: an octree that is divided where its interpolant misses the distance.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/adaptive.h"

#include "distance_transform/band_tiles.h"
#include "distance_transform/leaf_judge.h"
#include "distance_transform/progress_meter.h"
#include "volume/hanging_nodes.h"

#include <tbb/concurrent_vector.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

namespace isocast {

namespace {

/// Levels that are divided whatever the distance, so that threads have something to share.
constexpr int divided_levels = 3;

NodeData node_data(const ExactDistance::Sample& sample) {
    // Mixed derivatives are taken for zero: they would need second derivatives of the distance.
    return {static_cast<float>(sample.distance),
            static_cast<float>(sample.gradient.x()),
            static_cast<float>(sample.gradient.y()),
            0,
            static_cast<float>(sample.gradient.z()),
            0,
            0,
            0};
}

/// Calls work(first, end) for parts of 0 … count, in parallel. The parts are always the same, so
/// that what one hands to the next in them, as hints, does not depend on threads.
template<class Work>
void for_each_part(std::size_t count, const Work& work) {
    constexpr std::size_t part = 256;
    tbb::parallel_for(std::size_t{0}, (count + part - 1) / part,
                      [&](std::size_t i) { work(part * i, std::min(part * (i + 1), count)); });
}

using Leaf = HashedOctree::Found;

/// A tree that grows, with its nodes as they were sampled, whether they are constrained or not.
class GrowingTree {
public:
    GrowingTree(const ExactDistance& distance, const AdaptiveOptions& options)
        : distance_(distance), options_(options), judge_(distance, options),
          tree_(options.depth, options.filter, [&](const Index3& position, std::span<float> out) {
              ExactDistance::Hint hint = 0;
              sample(position, hint, out);
          }) {
        keep_new_nodes();
        new_cells_ = {root()};
    }

    Leaf root() const { return {tree_.root(), number_of(tree_.root())}; }

    /// Divides the leaves that must be, and what they are divided into.
    void grow(std::vector<Leaf> leaves, const Progress& progress) {
        const auto level_of = [](const Leaf& leaf) { return leaf.cell.level; };
        const auto highest_level = [&] {
            return leaves.empty() ? 0 : level_of(std::ranges::max(leaves, {}, level_of));
        };
        const int levels = highest_level();
        while (!leaves.empty()) {
            const int level = highest_level(); // less each time
            const auto report = [&](std::string_view stage, double fraction) {
                progress(stage, (levels - level + fraction) / levels);
            };
            ProgressMeter meter(progress ? report : Progress{}, "octree",
                                static_cast<double>(leaves.size()), 4096);
            for_each_part(leaves.size(), [&](std::size_t first, std::size_t end) {
                ExactDistance::Hint hint = 0;
                for (std::size_t i = first; i < end; ++i) {
                    margins_[leaves[i].number] = judge_.margin_of(
                        cube_of(leaves[i].cell), sampled_corners(leaves[i].number), hint);
                    meter.add(1);
                }
            });
            std::erase_if(leaves,
                          [&](const Leaf& leaf) { return margins_[leaf.number].slack >= 0; });
            leaves = divide(leaves);
        }
    }

    /// Divides leaves that need not be divided. Where one holds no surface its children err no
    /// more than it did.
    void grow_spoilers(const std::vector<Leaf>& leaves, const Progress& progress) {
        std::vector<Leaf> children = divide(leaves);
        std::erase_if(children, [&](const Leaf& child) {
            const OctreeCell parent = parent_of(child.cell);
            // The corner that is opposite to the parent's.
            const auto middle =
                tree_.node_of(child.number, 7 ^ child_index(child.cell.position, child.cell.level));
            return is_empty(cube_of(parent), sampled_[middle * components()]);
        });
        grow(std::move(children), progress);
    }

    void constrain() {
        hanging_.constrain(
            tree_,
            [&](const Index3& position, std::span<float> out) {
                const std::size_t first = *tree_.find_node(position) * out.size();
                std::copy_n(&sampled_[first], out.size(), out.begin());
            },
            [&](const Index3& position) { changed_.push_back(position); });
    }

    /// The leaves over which nodes hang that spoil the interpolant of finer ones. Of each of these
    /// one corner is mended at a time, which often mends the others: the bunny takes 0.6 times the
    /// sampled nodes that it takes with all corners at once.
    std::vector<Leaf> spoilers() {
        const std::vector<Leaf> suspects = take_suspects();
        tbb::concurrent_vector<Leaf> found;
        tbb::concurrent_vector<Leaf> spoiled;
        for_each_part(suspects.size(), [&](std::size_t first, std::size_t end) {
            ExactDistance::Hint hint = 0;
            for (std::size_t i = first; i < end; ++i)
                if (const std::optional<int> corner = spoiling_corner(suspects[i], hint)) {
                    spoiled.push_back(suspects[i]);
                    const auto at =
                        child_of({suspects[i].cell.position, suspects[i].cell.level + 1}, *corner)
                            .position;
                    for_each_leaf_around(at, [&](const Leaf& leaf) {
                        const Index3 within = at - leaf.cell.position;
                        if ((within.array() != 0 && within.array() != leaf.cell.size()).any())
                            found.push_back(leaf);
                    });
                }
        });
        spoiled_.assign(spoiled.begin(), spoiled.end());
        std::vector<Leaf> all(found.begin(), found.end());
        std::ranges::sort(all, {}, &Leaf::number);
        const auto [first, last] = std::ranges::unique(all);
        all.erase(first, last);
        return all;
    }

    HashedOctree take() { return std::move(tree_); }

    /// Divides leaves, by number, and samples the new nodes.
    /// returns  the children that can be divided
    std::vector<Leaf> divide(const std::vector<Leaf>& leaves) {
        const auto count = static_cast<double>(tree_.cell_count() / 8 + leaves.size());
        const double bytes =
            count * (27 * (sizeof(HashedOctree::NodeNumber) + sizeof(Margin)) + 8 * sizeof(Leaf) +
                     least_nodes * (2 * components() * sizeof(float) + HangingNodes::bytes_a_node));
        if (bytes > options_.memory_bytes) refuse_memory(bytes, options_.memory_bytes);
        tree_.reserve(static_cast<std::size_t>(count));
        std::vector<Leaf> children;
        std::vector<Index3> positions;
        const std::size_t first_node = tree_.node_count();
        for (const auto& [cell, number] : leaves) {
            tree_.divide(cell, [&](const Index3& position, std::span<float>) {
                positions.push_back(position);
            });
            hanging_.add(tree_, cell);
            for (int i = 0; i < 8; ++i) {
                const OctreeCell child = child_of(cell, i);
                new_cells_.push_back({child, number_of(child)});
                if (child.level > 0) children.push_back(new_cells_.back());
            }
        }
        for_each_part(positions.size(), [&](std::size_t first, std::size_t end) {
            ExactDistance::Hint hint = 0;
            for (std::size_t i = first; i < end; ++i)
                sample(positions[i], hint,
                       tree_.data_of(static_cast<HashedOctree::NodeNumber>(first_node + i)));
        });
        keep_new_nodes();
        return children;
    }

private:
    /// New nodes of a divided cell whose neighbours are divided too: its middle, half of each
    /// face's and a quarter of each edge's.
    static constexpr std::size_t least_nodes = 7;

    void sample(const Index3& position, ExactDistance::Hint& hint, std::span<float> out) const {
        const ExactDistance::Sample sample = distance_.at(position.cast<double>(), hint);
        const NodeData data = node_data(sample);
        std::copy_n(data.begin(), out.size(), out.begin());
    }

    std::size_t components() const {
        return static_cast<std::size_t>(components_of(options_.filter));
    }
    HashedOctree::CellNumber number_of(const OctreeCell& cell) const { return *tree_.find(cell); }

    void keep_new_nodes() {
        for (std::size_t node = sampled_.size() / components(); node < tree_.node_count(); ++node) {
            const auto data =
                std::as_const(tree_).data_of(static_cast<HashedOctree::NodeNumber>(node));
            sampled_.insert(sampled_.end(), data.begin(), data.end());
        }
        margins_.resize(tree_.cell_number_end());
    }

    std::array<NodeData, 8> copy_of(const CornerData& corners) const {
        std::array<NodeData, 8> copy{};
        for (std::size_t i = 0; i < 8; ++i) std::copy_n(corners[i], components(), copy[i].begin());
        return copy;
    }
    std::array<NodeData, 8> sampled_corners(HashedOctree::CellNumber cell) const {
        const auto numbers = tree_.nodes_of(cell);
        CornerData corners;
        for (std::size_t i = 0; i < 8; ++i) corners[i] = &sampled_[numbers[i] * components()];
        return copy_of(corners);
    }

    /// The leaves that may be spoiled: new ones, those that were, and those of which a corner holds
    /// something else than when leaves were judged last.
    std::vector<Leaf> take_suspects() {
        std::vector<Leaf> suspects;
        std::vector<bool> is_suspect(tree_.cell_number_end());
        const auto add = [&](const Leaf& leaf) {
            if (!is_suspect[leaf.number]) suspects.push_back(leaf);
            is_suspect[leaf.number] = true;
        };
        std::ranges::for_each(std::exchange(new_cells_, {}), add);
        std::ranges::for_each(std::exchange(spoiled_, {}), add);
        for (const Index3& position : std::exchange(changed_, {}))
            if (was_judged_) for_each_leaf_around(position, add);
        was_judged_ = true;
        std::ranges::sort(suspects, {}, &Leaf::number);
        return suspects;
    }
    template<class Visit>
    void for_each_leaf_around(const Index3& position, const Visit& visit) const {
        for (int k = 0; k < 8; ++k) {
            const Vec3d p = position.cast<double>() + 0.5 * corner_direction(k);
            if ((p.array() < 0).any() || (p.array() > tree_.root().size()).any()) continue;
            visit(tree_.find_leaf(p));
        }
    }

    std::optional<int> spoiling_corner(const Leaf& cell, ExactDistance::Hint& hint) {
        const auto nodes = tree_.nodes_of(cell.number);
        if (std::ranges::none_of(nodes, [&](auto node) { return tree_.is_constrained(node); }) ||
            tree_.is_divided(cell.cell))
            return std::nullopt;
        return judge_.spoiling_corner(cell.cell, margins_[cell.number],
                                      sampled_corners(cell.number),
                                      copy_of(tree_.corners_of(cell.number)), hint);
    }

    const ExactDistance& distance_;
    const AdaptiveOptions& options_;
    LeafJudge judge_;
    HashedOctree tree_;
    HangingNodes hanging_;
    std::vector<float> sampled_;  // components() a node
    std::vector<Margin> margins_; // by the number of a cell
    // Since leaves were judged last.
    std::vector<Leaf> new_cells_; // divided ones too
    std::vector<Index3> changed_; // nodes that hold something else
    std::vector<Leaf> spoiled_;
    bool was_judged_ = false;
};

} // namespace

HashedOctree build_adaptive(const ExactDistance& distance, const AdaptiveOptions& options,
                            const Progress& progress) {
    GrowingTree tree(distance, options);
    std::vector<Leaf> leaves; // that can be divided
    if (options.depth > 0) leaves = {tree.root()};
    for (int i = 0; i < std::min(divided_levels, options.depth); ++i) leaves = tree.divide(leaves);
    tree.grow(std::move(leaves), progress);
    tree.constrain();
    if (options.max_error_cells) {
        // Ends: each turn divides leaves.
        for (std::vector<Leaf> coarse; !(coarse = tree.spoilers()).empty();) {
            tree.grow_spoilers(coarse, progress);
            tree.constrain();
        }
    }
    return tree.take();
}

} // namespace isocast
