// A kD-tree over points, split at medians of the longest side.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/point_tree.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace isocast {

namespace {

double squared_distance(const WorldBox& box, const Vec3d& p) {
    return (p - p.cwiseMax(box.min).cwiseMin(box.max)).squaredNorm();
}

} // namespace

PointTree::PointTree(std::span<const Vec3d> points)
    : points_(points.begin(), points.end()), numbers_(points.size()) {
    std::iota(numbers_.begin(), numbers_.end(), 0);
    if (points.empty()) return;
    build(0, static_cast<std::int32_t>(points.size()));
    std::vector<Vec3d> in_order(points.size());
    std::ranges::transform(numbers_, in_order.begin(), [&](std::int32_t i) { return points_[i]; });
    points_ = std::move(in_order);
}

void PointTree::build(std::int32_t first, std::int32_t count) {
    constexpr std::int32_t leaf_points = 8; // 4 to 16 take the same time within a tenth
    const std::span numbers(numbers_.data() + first, static_cast<std::size_t>(count));
    WorldBox box{points_[numbers[0]], points_[numbers[0]]};
    for (const std::int32_t i : numbers)
        box = {box.min.cwiseMin(points_[i]), box.max.cwiseMax(points_[i])};
    const std::size_t node = nodes_.size();
    nodes_.push_back({box, first, count <= leaf_points ? count : 0, 0});
    if (count <= leaf_points) return;
    int axis = 0;
    box.size().maxCoeff(&axis);
    const std::int32_t half = count / 2;
    std::nth_element(numbers.begin(), numbers.begin() + half, numbers.end(),
                     [&](std::int32_t a, std::int32_t b) {
                         return std::pair(points_[a][axis], a) < std::pair(points_[b][axis], b);
                     });
    build(first, half);
    nodes_[node].right = static_cast<std::int32_t>(nodes_.size());
    build(first + half, count - half);
}

template<class Greatest, class AtPoint>
void PointTree::visit(const Vec3d& p, const Greatest& greatest, const AtPoint& at_point) const {
    if (nodes_.empty()) return;
    struct Pending {
        double squared_distance;
        std::int32_t node;
    };
    std::array<Pending, 64> pending; // halving 2^31 points leaves one sibling at each of 31 levels
    pending[0] = {squared_distance(nodes_[0].box, p), 0};
    for (int count = 1; count > 0;) {
        const Pending next = pending[--count];
        if (next.squared_distance > greatest()) continue;
        const Node& node = nodes_[next.node];
        if (node.count > 0) {
            for (std::int32_t i = node.first; i < node.first + node.count; ++i)
                at_point(Neighbour{(points_[i] - p).squaredNorm(), numbers_[i]});
            continue;
        }
        Pending near{squared_distance(nodes_[next.node + 1].box, p), next.node + 1};
        Pending far{squared_distance(nodes_[node.right].box, p), node.right};
        if (far.squared_distance < near.squared_distance) std::swap(near, far);
        pending[count++] = far;
        pending[count++] = near;
    }
}

void PointTree::nearest(const Vec3d& p, std::size_t count, std::vector<Neighbour>& found) const {
    found.clear();
    if (count == 0) return;
    visit(
        p,
        [&] {
            return found.size() < count ? std::numeric_limits<double>::infinity()
                                        : found.front().squared_distance;
        },
        [&](const Neighbour& next) {
            if (found.size() == count) {
                if (!(next < found.front())) return;
                std::ranges::pop_heap(found);
                found.back() = next;
            } else {
                found.push_back(next);
            }
            std::ranges::push_heap(found);
        });
    std::ranges::sort_heap(found);
}

void PointTree::within(const Vec3d& p, double radius, std::vector<Neighbour>& found) const {
    found.clear();
    const double greatest = radius * radius;
    visit(
        p, [&] { return greatest; },
        [&](const Neighbour& next) {
            if (next.squared_distance <= greatest) found.push_back(next);
        });
}

} // namespace isocast
