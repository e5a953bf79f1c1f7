// Adaptive distance fields: an octree that is divided where its interpolant misses the distance.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/adaptive.h"

#include "distance_transform/band_tiles.h"
#include "distance_transform/progress_meter.h"

#include <tbb/concurrent_vector.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
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

/// No surface where the distance at the centre exceeds the way to the farthest point of the cell.
bool is_empty(const Cube& cube, double distance_at_centre) {
    return std::abs(distance_at_centre) > std::numbers::sqrt3 * cube.half_edge;
}

Cube cube_of(const OctreeCell& cell) {
    const double half = cell.size() / 2.0;
    return {(cell.position.cast<double>().array() + half).matrix(), half};
}

/// By how much a leaf keeps what it must.
struct Margin {
    bool is_known = false;     // others, of finest leaves, are found once a corner has moved
    float slack = 0;           // what its corners may move by
    float error_at_centre = 0; // of the interpolant less the distance
};

/// Calls work(first, end) for parts of 0 … count, in parallel. The parts are always the same, so
/// that what one hands to the next in them, as hints, does not depend on threads.
template<class Work>
void for_each_part(std::size_t count, const Work& work) {
    constexpr std::size_t part = 256;
    tbb::parallel_for(std::size_t{0}, (count + part - 1) / part,
                      [&](std::size_t i) { work(part * i, std::min(part * (i + 1), count)); });
}

/// Judges leaves.
class Judge {
public:
    Judge(const ExactDistance& distance, const AdaptiveOptions& options)
        : distance_(distance), options_(options) {}

    /// Slack below 0 if the cell must be divided.
    Margin margin_of(const Cube& cube, const std::array<NodeData, 8>& corners,
                     ExactDistance::Hint& hint) const {
        const CellFunction g(options_.filter, cube.lo(), 2 * cube.half_edge, corners);
        if (!options_.max_error_cells)
            return {true, distance_.surface_in(cube, g, 0).is_there ? -1.0F : 0.0F};
        const double distance = distance_.at(cube.centre, hint).distance;
        Margin margin{true, static_cast<float>(slack_at(g, cube.centre, distance)),
                      static_cast<float>(g.at(cube.centre) - distance)};
        if (margin.slack < 0) return margin;
        const SurfaceInCube surface =
            is_empty(cube, distance) ? SurfaceInCube{}
                                     : distance_.surface_in(cube, g, *options_.max_error_cells);
        const double slack = surface.is_there ? slack_at_surface(cube, surface, corners)
                                              : slack_at_points(cube, g, hint);
        margin.slack = std::min(margin.slack, static_cast<float>(slack));
        return margin;
    }

    /// Whether a leaf that was good with the corners that were sampled no longer is.
    bool is_spoiled(const OctreeCell& cell, Margin& margin, const std::array<NodeData, 8>& sampled,
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
        if (moved == 0) return false;
        const Cube cube = cube_of(cell);
        if (!margin.is_known) {
            ExactDistance::Hint hint = 0;
            margin = margin_of(cube, sampled, hint);
        }
        if (margin.slack < 0 || (moved <= margin.slack && !has_changed_side)) return false;
        const CellFunction before(options_.filter, cube.lo(), 2 * cube.half_edge, sampled);
        const CellFunction g(options_.filter, cube.lo(), 2 * cube.half_edge, now);
        const double distance = before.at(cube.centre) - margin.error_at_centre;
        if (slack_at(g, cube.centre, distance) < 0) return true;
        const SurfaceInCube surface =
            is_empty(cube, distance) ? SurfaceInCube{}
                                     : distance_.surface_in(cube, g, *options_.max_error_cells);
        return surface.is_there ? slack_at_surface(cube, surface, now) < 0 : has_changed_side;
    }

private:
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
    double slack_at_points(const Cube& cube, const CellFunction& g,
                           ExactDistance::Hint& hint) const {
        double slack = std::numeric_limits<double>::infinity();
        const auto ask = [&](const Vec3d& from_centre) {
            const Vec3d p = cube.centre + cube.half_edge * from_centre;
            slack = std::min(slack, slack_at(g, p, distance_.at(p, hint).distance));
        };
        for (int axis = 0; axis < 3 && slack >= 0; ++axis) ask(Vec3d::Unit(axis));
        if (options_.filter == OctreeFilter::Linear) return slack;
        for (int i = 0; i < 8 && slack >= 0; ++i) ask(corner_direction(i) / 2);
        return slack;
    }

    double slack_at(const CellFunction& g, const Vec3d& p, double distance) const {
        const double beyond = std::abs(distance) - options_.accurate_within_cells;
        const double allowed = std::max(*options_.max_error_cells, far_share * beyond);
        return allowed - std::abs(distance - g.at(p));
    }

    const ExactDistance& distance_;
    const AdaptiveOptions& options_;
};

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
    }

    /// Divides the leaves that must be, and what they are divided into.
    void grow(std::vector<OctreeCell> leaves, const Progress& progress) {
        const auto highest_level = [&] {
            return leaves.empty() ? 0 : std::ranges::max(leaves, {}, &OctreeCell::level).level;
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
                    margins_[number_of(leaves[i])] =
                        judge_.margin_of(cube_of(leaves[i]), sampled_corners(leaves[i]), hint);
                    meter.add(1);
                }
            });
            std::erase_if(leaves, [&](const OctreeCell& leaf) {
                return margins_[number_of(leaf)].slack >= 0;
            });
            leaves = divide(leaves);
        }
    }

    /// Divides leaves that need not be divided. Where one holds no surface its children err no
    /// more than it did.
    void grow_spoilers(const std::vector<OctreeCell>& leaves, const Progress& progress) {
        const std::vector<OctreeCell> children = divide(leaves);
        std::vector<OctreeCell> growing;
        std::ranges::copy_if(children, std::back_inserter(growing), [&](const OctreeCell& child) {
            const OctreeCell parent = cell_around(child.position, child.level + 1);
            const auto middle = tree_.node_of(number_of(child_of(parent, 0)), 7);
            return !is_empty(cube_of(parent), sampled_[middle * components()]);
        });
        grow(std::move(growing), progress);
    }

    void constrain() {
        tree_.constrain_hanging_nodes([&](const Index3& position, std::span<float> out) {
            const std::size_t first = *tree_.find_node(position) * out.size();
            std::copy_n(&sampled_[first], out.size(), out.begin());
        });
    }

    /// The leaves over which nodes hang that spoil the interpolant of finer ones.
    std::vector<OctreeCell> spoilers() {
        std::vector<OctreeCell> leaves;
        tree_.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
            if (is_leaf) leaves.push_back(cell);
        });
        tbb::concurrent_vector<OctreeCell> found;
        for_each_part(leaves.size(), [&](std::size_t first, std::size_t end) {
            for (std::size_t i = first; i < end; ++i)
                if (is_spoiled(leaves[i])) add_coarser_neighbours(leaves[i], found);
        });
        std::vector<OctreeCell> all(found.begin(), found.end());
        std::ranges::sort(all, zyx_less, &OctreeCell::position);
        const auto [first, last] = std::ranges::unique(all);
        all.erase(first, last);
        return all;
    }

    HashedOctree take() { return std::move(tree_); }

    /// Divides leaves and samples the new nodes.
    /// returns  the children that can be divided
    std::vector<OctreeCell> divide(const std::vector<OctreeCell>& leaves) {
        const auto count = static_cast<double>(tree_.cell_count() / 8 + leaves.size());
        const double bytes = count * (27 * (sizeof(HashedOctree::NodeNumber) + sizeof(Margin)) +
                                      least_nodes * 2 * components() * sizeof(float));
        if (bytes > options_.memory_bytes) refuse_memory(bytes, options_.memory_bytes);
        tree_.reserve(static_cast<std::size_t>(count));
        std::vector<OctreeCell> children;
        std::vector<Index3> positions;
        const std::size_t first_node = tree_.node_count();
        for (const OctreeCell& leaf : leaves) {
            tree_.divide(leaf, [&](const Index3& position, std::span<float>) {
                positions.push_back(position);
            });
            for (int i = 0; i < 8 && leaf.level > 1; ++i) children.push_back(child_of(leaf, i));
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
    std::array<NodeData, 8> sampled_corners(const OctreeCell& cell) const {
        const auto numbers = tree_.nodes_of(number_of(cell));
        CornerData corners;
        for (std::size_t i = 0; i < 8; ++i) corners[i] = &sampled_[numbers[i] * components()];
        return copy_of(corners);
    }

    bool is_spoiled(const OctreeCell& leaf) {
        const auto number = number_of(leaf);
        if (std::ranges::none_of(tree_.nodes_of(number),
                                 [&](auto node) { return tree_.is_constrained(node); }))
            return false;
        return judge_.is_spoiled(leaf, margins_[number], sampled_corners(leaf),
                                 copy_of(tree_.corners_of(number)));
    }

    /// The leaves that have a constrained corner of the cell on an edge or a face.
    void add_coarser_neighbours(const OctreeCell& cell,
                                tbb::concurrent_vector<OctreeCell>& found) const {
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

    const ExactDistance& distance_;
    const AdaptiveOptions& options_;
    Judge judge_;
    HashedOctree tree_;
    std::vector<float> sampled_;  // components() a node
    std::vector<Margin> margins_; // by the number of a cell
};

} // namespace

HashedOctree build_adaptive(const ExactDistance& distance, const AdaptiveOptions& options,
                            const Progress& progress) {
    GrowingTree tree(distance, options);
    std::vector<OctreeCell> leaves; // that can be divided
    if (options.depth > 0) leaves.push_back({Index3::Zero(), options.depth});
    for (int i = 0; i < std::min(divided_levels, options.depth); ++i) leaves = tree.divide(leaves);
    tree.grow(std::move(leaves), progress);
    tree.constrain();
    if (options.max_error_cells) {
        // Ends: each turn divides leaves.
        for (std::vector<OctreeCell> coarse; !(coarse = tree.spoilers()).empty();) {
            tree.grow_spoilers(coarse, progress);
            tree.constrain();
        }
    }
    return tree.take();
}

} // namespace isocast
