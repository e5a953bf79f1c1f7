// Boxes around triangles or points, boxes around these.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/box_tree.h"

#include <algorithm>
#include <numeric>

namespace isocast {

namespace {

/// The middle, twice.
Vec3d middle_of(const WorldBox& box) {
    return box.min + box.max;
}

} // namespace

BoxTree::BoxTree(std::span<const WorldBox> boxes, std::int32_t leaf_items) : order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.reserve(boxes.size());
    if (!boxes.empty()) build(boxes, leaf_items, 0, static_cast<std::int32_t>(boxes.size()));
}

void BoxTree::build(std::span<const WorldBox> boxes, std::int32_t leaf_items, std::int32_t first,
                    std::int32_t count) {
    const std::span<std::int32_t> own =
        std::span(order_).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count));
    const auto box_of = [&](std::int32_t i) -> const WorldBox& {
        return boxes[static_cast<std::size_t>(i)];
    };
    Eigen::AlignedBox3d all;
    Eigen::AlignedBox3d middles;
    for (const std::int32_t i : own) {
        all.extend(box_of(i).min).extend(box_of(i).max);
        middles.extend(middle_of(box_of(i)));
    }
    const std::size_t node = nodes_.size();
    nodes_.push_back({{all.min(), all.max()}, 0, first, count});
    if (count <= leaf_items) return;
    int axis = 0;
    middles.sizes().maxCoeff(&axis);
    const std::int32_t half = count / 2;
    std::ranges::nth_element(own, own.begin() + half, {}, [&](std::int32_t i) {
        return std::pair(middle_of(box_of(i))[axis], i);
    });
    build(boxes, leaf_items, first, half);
    nodes_[node].right = static_cast<std::int32_t>(nodes_.size());
    build(boxes, leaf_items, first + half, count - half);
}

} // namespace isocast
