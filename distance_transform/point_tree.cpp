// A tree over points: the nearest ones to a place, and those within a radius of it.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/point_tree.h"

#include <algorithm>
#include <limits>

namespace isocast {

namespace {

constexpr std::int32_t leaf_points = 8; // 4 to 16 take the same time within a tenth

std::vector<WorldBox> boxes_of(std::span<const Vec3d> points) {
    std::vector<WorldBox> boxes;
    boxes.reserve(points.size());
    for (const Vec3d& p : points) boxes.push_back({p, p});
    return boxes;
}

} // namespace

PointTree::PointTree(std::span<const Vec3d> points)
    : tree_(boxes_of(points), leaf_points), points_(points.size()) {
    std::ranges::transform(tree_.order(), points_.begin(),
                           [&](std::int32_t i) { return points[static_cast<std::size_t>(i)]; });
}

template<class Greatest, class AtPoint>
void PointTree::visit(const Vec3d& p, const Greatest& greatest, const AtPoint& at_point) const {
    tree_.visit_near(p, greatest, [&](std::int32_t first, std::int32_t end) {
        for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(end); ++i)
            at_point(Neighbour{(points_[i] - p).squaredNorm(), tree_.order()[i]});
    });
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
