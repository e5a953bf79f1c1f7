// Building a kD-tree: sampled median, three sets, and the sweep that places two split planes.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/kd_tree_build.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <random>

namespace isocast {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A triangle, or with split references its part within a node, by its box.
struct Item {
    std::int32_t triangle;
    Vec3d lo;
    Vec3d hi;
    double centre(int axis) const { return lo[axis] / 2 + hi[axis] / 2; }
};
using Items = std::vector<Item>;

struct Split {
    int axis = 0;
    double cost = infinity;
    double left_end = 0;
    double right_begin = 0;
    Items left, right, stay;
};

void append(Items& to, const Items& from) {
    to.insert(to.end(), from.begin(), from.end());
}

/// A few triangles cost less than the visit of two more nodes: of 1, 2, 4, 8 the fastest for the
/// bunny's closest points and rays.
constexpr std::size_t leaf_size = 4;
/// The visit of a node in units of a triangle's distance.
constexpr double visit_cost = 0.5;
/// A triangle of the middle is big, and stays at the node, if it is longer than this part of it.
constexpr double big_part = 0.5;
/// Enough that the median lies between the quartiles but for one time in 400.
constexpr std::size_t median_sample = 31;
/// Each repetition halves the uneven part or nearly so; then the partition is taken as it is.
constexpr int greatest_repetitions = 8;
/// Subtrees with more items than this are worth a task.
constexpr std::size_t parallel_size = 4096;
/// References for each triangle that splitting may add.
constexpr double greatest_duplication = 4;

class Builder {
public:
    explicit Builder(KdVariant variant) : variant_(variant) {}

    /// budget  how many references may be added below this node
    void build(Items items, int depth, double budget, KdNodes& out) const {
        const std::size_t index = out.nodes.size();
        out.nodes.emplace_back();
        std::optional<Split> split;
        if (items.size() > leaf_size && depth < greatest_kd_depth) split = best_split(items);
        const double added = split ? static_cast<double>(split->left.size() + split->right.size() +
                                                         split->stay.size() - items.size())
                                   : 0;
        if (!split || added > budget) {
            store(items, out.nodes[index], out);
            return;
        }
        store(split->stay, out.nodes[index], out);
        out.nodes[index].axis = split->axis;
        out.nodes[index].left_end = split->left_end;
        out.nodes[index].right_begin = split->right_begin;
        const double left_share = static_cast<double>(split->left.size()) /
                                  static_cast<double>(split->left.size() + split->right.size());
        const double left_budget = (budget - added) * left_share;
        const double right_budget = budget - added - left_budget;
        const bool is_large = items.size() > parallel_size;
        items = {};
        if (is_large) {
            KdNodes right;
            tbb::parallel_invoke(
                [&] { build(std::move(split->left), depth + 1, left_budget, out); },
                [&] { build(std::move(split->right), depth + 1, right_budget, right); });
            out.nodes[index].right = static_cast<std::int32_t>(out.nodes.size());
            append_subtree(right, out);
        } else {
            build(std::move(split->left), depth + 1, left_budget, out);
            out.nodes[index].right = static_cast<std::int32_t>(out.nodes.size());
            build(std::move(split->right), depth + 1, right_budget, out);
        }
    }

private:
    static void store(const Items& items, KdNode& node, KdNodes& out) {
        node.first = static_cast<std::int32_t>(out.triangles.size());
        node.count = static_cast<std::int32_t>(items.size());
        for (const Item& item : items) out.triangles.push_back(item.triangle);
    }

    static void append_subtree(const KdNodes& subtree, KdNodes& out) {
        const auto node_offset = static_cast<std::int32_t>(out.nodes.size());
        const auto triangle_offset = static_cast<std::int32_t>(out.triangles.size());
        for (KdNode node : subtree.nodes) {
            node.first += triangle_offset;
            if (node.right > 0) node.right += node_offset;
            out.nodes.push_back(node);
        }
        out.triangles.insert(out.triangles.end(), subtree.triangles.begin(),
                             subtree.triangles.end());
    }

    /// Along the axis of greatest variation; along the next where that does not pay.
    std::optional<Split> best_split(const Items& items) const {
        Vec3d lo = Vec3d::Constant(infinity);
        Vec3d hi = -lo;
        Vec3d least = lo;
        Vec3d greatest = hi;
        for (const Item& item : items) {
            lo = lo.cwiseMin(item.lo);
            hi = hi.cwiseMax(item.hi);
            const Vec3d centre = item.lo / 2 + item.hi / 2;
            least = least.cwiseMin(centre);
            greatest = greatest.cwiseMax(centre);
        }
        const Vec3d variation = greatest - least;
        std::array axes = {0, 1, 2};
        std::ranges::sort(axes, [&](int a, int b) { return variation[a] > variation[b]; });
        const double whole = static_cast<double>(items.size()) * (hi - lo).sum();
        for (const int axis : axes) {
            if (!(variation[axis] > 0)) break;
            Split split = divide(items, axis, lo, hi);
            if (split.cost < whole) return split;
        }
        return std::nullopt;
    }

    /// Thesis 4.1.2, figure 4.1 a, b: partition about a guess of the median; while that is uneven,
    /// the smaller side is final and the rest is partitioned again.
    Split divide(const Items& items, int axis, const Vec3d& lo, const Vec3d& hi) const {
        Split split{.axis = axis};
        Items working = items;
        Items below;
        Items above;
        Items middle;
        std::minstd_rand random(static_cast<unsigned>(items.size()));
        // Planes between these leave what is final on its side.
        double least_plane = -infinity;
        double greatest_plane = infinity;
        double plane = 0;
        for (int repetition = 0;; ++repetition) {
            const double wanted =
                (static_cast<double>(items.size()) / 2 - static_cast<double>(split.left.size())) /
                static_cast<double>(working.size());
            plane = std::clamp(sampled_quantile(working, axis, wanted, random), least_plane,
                               greatest_plane);
            below.clear();
            above.clear();
            middle.clear();
            for (const Item& item : working)
                (item.hi[axis] <= plane   ? below
                 : item.lo[axis] >= plane ? above
                                          : middle)
                    .push_back(item);
            const std::size_t left_count = split.left.size() + below.size();
            const std::size_t right_count = split.right.size() + above.size();
            const std::size_t difference =
                std::max(left_count, right_count) - std::min(left_count, right_count);
            if (difference <= items.size() / 8 + 1 || repetition == greatest_repetitions) break;
            if (left_count < right_count) {
                append(split.left, below);
                least_plane = plane;
                working.swap(above);
            } else {
                append(split.right, above);
                greatest_plane = plane;
                working.swap(below);
            }
            append(working, middle);
        }
        append(split.left, below);
        append(split.right, above);
        assign_middle(middle, plane, lo, hi, split);
        return split;
    }

    static double sampled_quantile(const Items& items, int axis, double quantile,
                                   std::minstd_rand& random) {
        std::array<double, median_sample> centres;
        const std::size_t count = std::min(median_sample, items.size());
        for (std::size_t i = 0; i < count; ++i)
            centres[i] =
                items[items.size() <= median_sample ? i : random() % items.size()].centre(axis);
        const auto at = centres.begin() +
                        static_cast<std::ptrdiff_t>(
                            std::clamp(quantile, 0.0, 1.0) * static_cast<double>(count - 1) + 0.5);
        std::nth_element(centres.begin(), at, centres.begin() + static_cast<std::ptrdiff_t>(count));
        return *at;
    }

    void assign_middle(Items& middle, double plane, const Vec3d& lo, const Vec3d& hi,
                       Split& split) const {
        const int axis = split.axis;
        const double width = (hi - lo).sum();
        const auto cost = [&](std::size_t left, std::size_t right, std::size_t stay,
                              double left_end, double right_begin) {
            return static_cast<double>(left) * (width - (hi[axis] - left_end)) +
                   static_cast<double>(right) * (width - (right_begin - lo[axis])) +
                   (static_cast<double>(stay) + visit_cost) * width;
        };
        if (variant_ == KdVariant::Overlapping) {
            sweep(middle, lo, hi, split, cost);
            return;
        }
        split.left_end = split.right_begin = plane;
        if (variant_ == KdVariant::ObjectsAtNodes) {
            split.stay = std::move(middle);
        } else {
            for (const Item& item : middle) {
                split.left.push_back(item);
                split.left.back().hi[axis] = plane;
                split.right.push_back(item);
                split.right.back().lo[axis] = plane;
            }
        }
        split.cost = cost(split.left.size(), split.right.size(), split.stay.size(), plane, plane);
    }

    /// Thesis 4.1.2, figure 4.1 c, d: big ones stay; the others, by where they begin, all go to the
    /// right at first and then one after the other to the left.
    template<class Cost>
    static void sweep(Items& middle, const Vec3d& lo, const Vec3d& hi, Split& split,
                      const Cost& cost) {
        const int axis = split.axis;
        const double big = big_part * (hi[axis] - lo[axis]);
        const auto first_big = std::partition(middle.begin(), middle.end(), [&](const Item& item) {
            return item.hi[axis] - item.lo[axis] <= big;
        });
        split.stay.assign(first_big, middle.end());
        middle.erase(first_big, middle.end());
        std::ranges::sort(middle, [axis](const Item& a, const Item& b) {
            return std::pair(a.lo[axis], a.triangle) < std::pair(b.lo[axis], b.triangle);
        });
        double left_end = lo[axis];
        for (const Item& item : split.left) left_end = std::max(left_end, item.hi[axis]);
        double right_least = hi[axis];
        for (const Item& item : split.right) right_least = std::min(right_least, item.lo[axis]);
        std::size_t best = 0;
        for (std::size_t to_left = 0; to_left <= middle.size(); ++to_left) {
            if (to_left > 0) left_end = std::max(left_end, middle[to_left - 1].hi[axis]);
            const double right_begin = to_left < middle.size()
                                           ? std::min(right_least, middle[to_left].lo[axis])
                                           : right_least;
            const double found =
                cost(split.left.size() + to_left, split.right.size() + middle.size() - to_left,
                     split.stay.size(), left_end, right_begin);
            if (found >= split.cost) continue;
            split.cost = found;
            split.left_end = left_end;
            split.right_begin = right_begin;
            best = to_left;
        }
        const auto cut = middle.begin() + static_cast<std::ptrdiff_t>(best);
        split.left.insert(split.left.end(), middle.begin(), cut);
        split.right.insert(split.right.end(), cut, middle.end());
    }

    KdVariant variant_;
};

} // namespace

KdNodes build_kd_nodes(const Mesh& mesh, KdVariant variant) {
    Items items;
    items.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [ia, ib, ic] = mesh.triangles[t];
        const Vec3d& a = mesh.vertices_world[ia];
        const Vec3d& b = mesh.vertices_world[ib];
        const Vec3d& c = mesh.vertices_world[ic];
        items.push_back(
            {static_cast<std::int32_t>(t), a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)});
    }
    const double budget = greatest_duplication * static_cast<double>(items.size());
    KdNodes result;
    Builder(variant).build(std::move(items), 1, budget, result);
    return result;
}

} // namespace isocast
