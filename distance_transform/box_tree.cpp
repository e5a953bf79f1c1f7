// Boxes around triangles, boxes around these.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/box_tree.h"

#include <algorithm>
#include <numeric>

namespace isocast {

namespace {

constexpr std::int32_t leaf_triangles = 2;

Vec3d middle_of(const std::array<Vec3d, 3>& corners) {
    return corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]) +
           corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
}

} // namespace

BoxTree::BoxTree(std::span<const std::array<Vec3d, 3>> triangles) : order_(triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.reserve(triangles.size());
    build(triangles, 0, static_cast<std::int32_t>(triangles.size()));
}

void BoxTree::build(std::span<const std::array<Vec3d, 3>> triangles, std::int32_t first,
                    std::int32_t count) {
    const std::span<std::int32_t> own =
        std::span(order_).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count));
    const auto corners_of = [&](std::int32_t t) -> const std::array<Vec3d, 3>& {
        return triangles[static_cast<std::size_t>(t)];
    };
    Eigen::AlignedBox3d box;
    Eigen::AlignedBox3d middles;
    for (const std::int32_t t : own) {
        for (const Vec3d& corner : corners_of(t)) box.extend(corner);
        middles.extend(middle_of(corners_of(t)));
    }
    const std::size_t node = nodes_.size();
    nodes_.push_back({box.min(), box.max(), 0, first, count});
    if (count <= leaf_triangles) return;
    int axis = 0;
    middles.sizes().maxCoeff(&axis);
    const std::int32_t half = count / 2;
    std::ranges::nth_element(own, own.begin() + half, {}, [&](std::int32_t t) {
        return std::pair(middle_of(corners_of(t))[axis], t);
    });
    build(triangles, first, half);
    nodes_[node].right = static_cast<std::int32_t>(nodes_.size());
    build(triangles, first + half, count - half);
}

} // namespace isocast
