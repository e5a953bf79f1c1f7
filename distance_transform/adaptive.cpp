// Adaptive distance fields: an octree that is divided where its interpolant misses the distance.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/adaptive.h"

#include "distance_transform/band_tiles.h"
#include "distance_transform/progress_meter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <bitset>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace isocast {

namespace {

/// Levels that are divided whatever the distance, so that threads have something to share.
constexpr int divided_levels = 3;

/// How fast the allowed error grows with the distance beyond AdaptiveOptions::accurate_within. The
/// bunny takes 1.6 times as many sampled nodes with a quarter of it, and as many with four times
/// it.
constexpr double far_share = 0.25;

/// The 27 nodes of a cell's children, x fastest.
constexpr std::size_t node_place(int x, int y, int z) {
    return static_cast<std::size_t>(x + 3 * (y + 3 * z));
}

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

Cube cube_of(const OctreeCell& cell) {
    const double half = cell.size() / 2.0;
    return {(cell.position.cast<double>().array() + half).matrix(), half};
}

/// The nodes of a cell's children, each sampled when it is first asked for.
class Nodes {
public:
    Nodes(const ExactDistance& distance, const Cube& cube, const std::array<NodeData, 8>& corners,
          ExactDistance::Hint& hint)
        : distance_(distance), cube_(cube), hint_(hint) {
        for (int i = 0; i < 8; ++i) {
            const std::size_t place = node_place(2 * (i & 1), i & 2, 2 * (i >> 2));
            data_[place] = corners[static_cast<std::size_t>(i)];
            is_known_.set(place);
        }
    }
    const NodeData& at(int x, int y, int z) {
        const std::size_t place = node_place(x, y, z);
        if (!is_known_[place]) data_[place] = node_data(distance_.at(point(x, y, z), hint_));
        is_known_.set(place);
        return data_[place];
    }
    Vec3d point(int x, int y, int z) const {
        return cube_.centre + cube_.half_edge * Vec3d(x - 1, y - 1, z - 1);
    }
    std::array<NodeData, 8> corners_of_child(int i) {
        std::array<NodeData, 8> corners;
        for (int k = 0; k < 8; ++k)
            corners[static_cast<std::size_t>(k)] =
                at((i & 1) + (k & 1), (i >> 1 & 1) + (k >> 1 & 1), (i >> 2) + (k >> 2));
        return corners;
    }
    const std::array<NodeData, 27>& all() {
        for (int z = 0; z < 3; ++z)
            for (int y = 0; y < 3; ++y)
                for (int x = 0; x < 3; ++x) at(x, y, z);
        return data_;
    }

private:
    const ExactDistance& distance_;
    const Cube& cube_;
    ExactDistance::Hint& hint_;
    std::array<NodeData, 27> data_{};
    std::bitset<27> is_known_;
};

/// By how much a leaf keeps what it must.
struct Margin {
    float slack = 0;           // what its corners may move by
    float error_at_centre = 0; // of the interpolant less the distance
};

/// What became of a subtree, in the order of HashedOctree::visit_cells.
struct Grown {
    struct Divided {
        OctreeCell cell;
        std::array<NodeData, 27> nodes;
    };
    std::vector<Divided> divided;
    std::vector<Margin> margins; // of each leaf
};

class Builder {
public:
    Builder(const ExactDistance& distance, const AdaptiveOptions& options)
        : distance_(distance), options_(options) {}

    void grow(const OctreeCell& cell, const std::array<NodeData, 8>& corners,
              ExactDistance::Hint& hint, Grown& grown) const {
        const Cube cube = cube_of(cell);
        Nodes nodes(distance_, cube, corners, hint);
        Margin margin;
        if (cell.level > 0 || options_.max_error_cells) {
            const CellFunction g(options_.filter, cube.lo(), 2 * cube.half_edge, corners);
            margin = margin_of(cube, g, corners, nodes, hint);
        }
        if (cell.level == 0 || margin.slack >= 0)
            grown.margins.push_back(margin);
        else
            grow_children(cell, nodes, hint, grown);
    }

    /// Divides a leaf that need not be divided. Where it holds no surface its children are leaves
    /// that err no more than it did.
    void divide(const OctreeCell& leaf, const std::array<NodeData, 8>& corners,
                const Margin& margin, ExactDistance::Hint& hint, Grown& grown) const {
        const Cube cube = cube_of(leaf);
        Nodes nodes(distance_, cube, corners, hint);
        if (is_empty(cube, nodes)) {
            add_divided(leaf, nodes, grown);
            grown.margins.insert(grown.margins.end(), 8, margin);
        } else {
            grow_children(leaf, nodes, hint, grown);
        }
    }

    /// Whether a leaf that was good with the corners that were sampled no longer is.
    bool is_spoiled(const OctreeCell& cell, const Margin& margin,
                    const std::array<NodeData, 8>& sampled,
                    const std::array<NodeData, 8>& now) const {
        double moved = 0;
        bool has_changed_side = false;
        for (std::size_t i = 0; i < 8; ++i) {
            double here = 0;
            // Both ends' slopes weigh a quarter of the edge at most, between them.
            for (unsigned d = 0; d < static_cast<unsigned>(components_of(options_.filter)); ++d)
                here += std::abs(double{now[i][d]} - sampled[i][d]) *
                        std::pow(cell.size() / 4.0, std::popcount(d));
            moved = std::max(moved, here);
            has_changed_side = has_changed_side || (now[i][0] < 0) != (sampled[i][0] < 0);
        }
        if (margin.slack < 0 || (moved <= margin.slack && !has_changed_side)) return false;
        const Cube cube = cube_of(cell);
        const CellFunction before(options_.filter, cube.lo(), 2 * cube.half_edge, sampled);
        const CellFunction g(options_.filter, cube.lo(), 2 * cube.half_edge, now);
        const double distance = before.at(cube.centre) - margin.error_at_centre;
        if (slack_at(g, cube.centre, distance) < 0) return true;
        const SurfaceInCube surface =
            std::abs(distance) > std::numbers::sqrt3 * cube.half_edge
                ? SurfaceInCube{}
                : distance_.surface_in(cube, g, *options_.max_error_cells);
        return surface.is_there ? slack_at_surface(cube, surface, now) < 0 : has_changed_side;
    }

private:
    void add_divided(const OctreeCell& cell, Nodes& nodes, Grown& grown) const {
        // Until the tree has it, which then takes a fifth of that.
        constexpr double bytes = sizeof(Grown::Divided) + 8 * sizeof(Margin);
        const double expected = bytes * static_cast<double>(++divided_count_);
        if (expected > options_.memory_bytes) refuse_memory(expected, options_.memory_bytes);
        grown.divided.push_back({cell, nodes.all()});
    }
    void grow_children(const OctreeCell& cell, Nodes& nodes, ExactDistance::Hint& hint,
                       Grown& grown) const {
        add_divided(cell, nodes, grown);
        for (int i = 0; i < 8; ++i) grow(child_of(cell, i), nodes.corners_of_child(i), hint, grown);
    }

    /// No surface where the distance exceeds the way to the farthest point of the cell.
    static bool is_empty(const Cube& cube, Nodes& nodes) {
        return std::abs(nodes.at(1, 1, 1)[0]) > std::numbers::sqrt3 * cube.half_edge;
    }

    /// Slack below 0 if the cell must be divided.
    Margin margin_of(const Cube& cube, const CellFunction& g,
                     const std::array<NodeData, 8>& corners, Nodes& nodes,
                     ExactDistance::Hint& hint) const {
        if (!options_.max_error_cells)
            return {distance_.surface_in(cube, g, 0).is_there ? -1.0F : 0.0F};
        const double distance = nodes.at(1, 1, 1)[0];
        Margin margin{static_cast<float>(slack_at(g, cube.centre, distance)),
                      static_cast<float>(g.at(cube.centre) - distance)};
        if (margin.slack < 0) return margin;
        const SurfaceInCube surface =
            is_empty(cube, nodes) ? SurfaceInCube{}
                                  : distance_.surface_in(cube, g, *options_.max_error_cells);
        const double slack = surface.is_there ? slack_at_surface(cube, surface, corners)
                                              : slack_at_points(cube, g, nodes, hint);
        margin.slack = std::min(margin.slack, static_cast<float>(slack));
        return margin;
    }

    double slack_at_surface(const Cube& cube, const SurfaceInCube& surface,
                            const std::array<NodeData, 8>& corners) const {
        const double max_error = *options_.max_error_cells;
        const bool is_inside = corners[0][0] < 0;
        const bool is_one_sided = std::ranges::all_of(
            corners, [&](const NodeData& corner) { return (corner[0] < 0) == is_inside; });
        const double from_low = (surface.box.max() - cube.lo()).minCoeff();
        const double from_high = (cube.hi() - surface.box.min()).minCoeff();
        if (is_one_sided && std::min(from_low, from_high) > hidden_share * max_error) return -1;
        return max_error - surface.bound;
    }

    /// At the middles of three faces, the others' being the neighbours', and where a cubic without
    /// mixed derivatives errs most.
    double slack_at_points(const Cube& cube, const CellFunction& g, Nodes& nodes,
                           ExactDistance::Hint& hint) const {
        double slack = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3 && slack >= 0; ++axis) {
            const Index3 n = Index3::Constant(1) + Index3::Unit(axis);
            slack = std::min(slack, slack_at(g, nodes.point(n.x(), n.y(), n.z()),
                                             nodes.at(n.x(), n.y(), n.z())[0]));
        }
        if (options_.filter == OctreeFilter::Linear) return slack;
        for (int i = 0; i < 8 && slack >= 0; ++i) {
            const Vec3d p = cube.centre + cube.half_edge / 2 * corner_direction(i);
            slack = std::min(slack, slack_at(g, p, distance_.at(p, hint).distance));
        }
        return slack;
    }

    double slack_at(const CellFunction& g, const Vec3d& p, double distance) const {
        const double beyond = std::abs(distance) - options_.accurate_within_cells;
        const double allowed = std::max(*options_.max_error_cells, far_share * beyond);
        return allowed - std::abs(distance - g.at(p));
    }

    const ExactDistance& distance_;
    const AdaptiveOptions& options_;
    mutable std::atomic<std::int64_t> divided_count_ = 0;
};

/// A tree that grows, with its nodes as they were sampled, whether they are constrained or not.
class GrowingTree {
public:
    GrowingTree(const ExactDistance& distance, const AdaptiveOptions& options)
        : options_(options), builder_(distance, options),
          tree_(options.depth, options.filter, sampler_of(distance)) {
        std::vector<OctreeCell> leaves = {tree_.root()};
        for (int i = 0; i < std::min(divided_levels, options.depth); ++i) {
            std::vector<OctreeCell> children;
            for (const OctreeCell& cell : leaves) {
                tree_.divide(cell, sampler_of(distance));
                for (int k = 0; k < 8; ++k) children.push_back(child_of(cell, k));
            }
            leaves = std::move(children);
        }
        keep_new_nodes();
        top_leaves_ = std::move(leaves);
    }

    /// Those with which growth starts.
    const std::vector<OctreeCell>& top_leaves() const { return top_leaves_; }

    /// Lets leaves grow, in the order of HashedOctree::visit_cells.
    void grow(const std::vector<OctreeCell>& leaves, const Progress& progress, bool must_divide) {
        std::vector<Grown> grown(leaves.size());
        ProgressMeter meter(progress, "octree", static_cast<double>(leaves.size()), 16);
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, leaves.size(), 1), [&](const auto& some) {
                for (std::size_t i = some.begin(); i < some.end(); ++i) {
                    ExactDistance::Hint hint = 0;
                    const std::array<NodeData, 8> corners = sampled_corners(leaves[i]);
                    if (must_divide)
                        builder_.divide(leaves[i], corners, margins_[number_of(leaves[i])], hint,
                                        grown[i]);
                    else
                        builder_.grow(leaves[i], corners, hint, grown[i]);
                    meter.add(1);
                }
            });
        std::size_t count = tree_.cell_count() / 8;
        for (const Grown& some : grown) count += some.divided.size();
        tree_.reserve(count);
        for (std::size_t i = 0; i < leaves.size(); ++i) {
            add(leaves[i], grown[i]);
            grown[i] = {};
        }
        keep_new_nodes();
    }

    void constrain() {
        tree_.constrain_hanging_nodes([&](const Index3& position, std::span<float> out) {
            const std::size_t first = *tree_.find_node(position) * out.size();
            std::copy_n(&sampled_[first], out.size(), out.begin());
        });
    }

    /// The leaves over which nodes hang that spoil the interpolant of finer ones.
    std::vector<OctreeCell> spoilers() const {
        std::vector<OctreeCell> leaves;
        tree_.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
            if (is_leaf) leaves.push_back(cell);
        });
        std::vector<std::vector<OctreeCell>> found(leaves.size() / 1024 + 1);
        tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t part) {
            for (std::size_t i = 1024 * part; i < std::min(1024 * (part + 1), leaves.size()); ++i)
                if (is_spoiled(leaves[i])) add_coarser_neighbours(leaves[i], found[part]);
        });
        std::vector<OctreeCell> all;
        for (const std::vector<OctreeCell>& some : found)
            all.insert(all.end(), some.begin(), some.end());
        std::ranges::sort(all, zyx_less, &OctreeCell::position);
        const auto [first, last] = std::ranges::unique(all);
        all.erase(first, last);
        return all;
    }

    HashedOctree take() { return std::move(tree_); }

private:
    static HashedOctree::NodeSampler sampler_of(const ExactDistance& distance) {
        return [&distance](const Index3& position, std::span<float> out) {
            ExactDistance::Hint hint = 0;
            const NodeData data = node_data(distance.at(position.cast<double>(), hint));
            std::copy_n(data.begin(), out.size(), out.begin());
        };
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
    std::array<NodeData, 8> sampled_corners(const OctreeCell& cell) const {
        const auto numbers = tree_.nodes_of(number_of(cell));
        CornerData corners;
        for (std::size_t i = 0; i < 8; ++i) corners[i] = &sampled_[numbers[i] * components()];
        return copy_of(corners);
    }

    void add(const OctreeCell& cell, const Grown& grown) {
        for (const Grown::Divided& divided : grown.divided)
            tree_.divide(divided.cell, [&](const Index3& position, std::span<float> out) {
                const Index3 at = 2 * (position - divided.cell.position) / divided.cell.size();
                std::copy_n(divided.nodes[node_place(at.x(), at.y(), at.z())].begin(), out.size(),
                            out.begin());
            });
        margins_.resize(tree_.cell_number_end());
        auto margin = grown.margins.begin();
        const auto keep = [&](const auto& self, const OctreeCell& leaf) -> void {
            if (!tree_.is_divided(leaf)) {
                margins_[number_of(leaf)] = *margin++;
                return;
            }
            for (int i = 0; i < 8; ++i) self(self, child_of(leaf, i));
        };
        keep(keep, cell);
    }

    bool is_spoiled(const OctreeCell& leaf) const {
        const auto number = number_of(leaf);
        return builder_.is_spoiled(leaf, margins_[number], sampled_corners(leaf),
                                   copy_of(tree_.corners_of(number)));
    }

    /// The leaves that have a constrained corner of the cell on an edge or a face.
    void add_coarser_neighbours(const OctreeCell& cell, std::vector<OctreeCell>& found) const {
        const auto numbers = tree_.nodes_of(number_of(cell));
        for (int i = 0; i < 8; ++i) {
            if (!tree_.is_constrained(numbers[static_cast<std::size_t>(i)])) continue;
            const Index3 corner = cell.position + cell.size() * Index3(i & 1, i >> 1 & 1, i >> 2);
            for (int k = 0; k < 8; ++k) {
                const Vec3d p = corner.cast<double>() + 0.5 * corner_direction(k);
                if ((p.array() < 0).any() || (p.array() > tree_.root().size()).any()) continue;
                const OctreeCell leaf = tree_.leaf_at(p);
                const Index3 within = corner - leaf.position;
                if ((within.array() != 0 && within.array() != leaf.size()).any())
                    found.push_back(leaf);
            }
        }
    }

    const AdaptiveOptions& options_;
    Builder builder_;
    HashedOctree tree_;
    std::vector<OctreeCell> top_leaves_;
    std::vector<float> sampled_;  // components() a node
    std::vector<Margin> margins_; // by the number of a cell
};

} // namespace

HashedOctree build_adaptive(const ExactDistance& distance, const AdaptiveOptions& options,
                            const Progress& progress) {
    GrowingTree tree(distance, options);
    tree.grow(tree.top_leaves(), progress, false);
    tree.constrain();
    if (options.max_error_cells) {
        // Ends: each turn divides leaves.
        for (std::vector<OctreeCell> coarse; !(coarse = tree.spoilers()).empty();) {
            tree.grow(coarse, progress, true);
            tree.constrain();
        }
    }
    return tree.take();
}

} // namespace isocast
