// Boxes around triangles or points, boxes around these.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/box_tree.h"

#include <tbb/parallel_invoke.h>

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
    if (boxes.empty()) return;
    std::iota(order_.begin(), order_.end(), 0);
    Eigen::AlignedBox3d all;
    for (const WorldBox& box : boxes) all.extend(box.min).extend(box.max);
    middle_ = all.center();
    nodes_.reserve(boxes.size() / static_cast<std::size_t>(leaf_items) + 1);
    nodes_.emplace_back();
    const Part whole{0, static_cast<std::int32_t>(boxes.size())};
    sort(boxes, leaf_items, whole);
    build(boxes, leaf_items, 0, whole);
}

std::span<std::int32_t> BoxTree::items_of(const Part& part) {
    return std::span(order_).subspan(static_cast<std::size_t>(part.first),
                                     static_cast<std::size_t>(part.count));
}

std::array<BoxTree::Part, 2> BoxTree::halves_of(const Part& part, std::int32_t leaf_items) {
    const std::int32_t half = (part.count / 2 + leaf_items - 1) / leaf_items * leaf_items;
    return {Part{part.first, half}, Part{part.first + half, part.count - half}};
}

/// Puts the items of each half where it is, in parallel.
void BoxTree::sort(std::span<const WorldBox> boxes, std::int32_t leaf_items, const Part& part) {
    if (part.count <= leaf_items) return;
    const std::span<std::int32_t> items = items_of(part);
    const auto middle = [&](std::int32_t i) {
        return middle_of(boxes[static_cast<std::size_t>(i)]);
    };
    Eigen::AlignedBox3d middles;
    for (const std::int32_t i : items) middles.extend(middle(i));
    int axis = 0;
    middles.sizes().maxCoeff(&axis);
    const auto [low, high] = halves_of(part, leaf_items);
    std::ranges::nth_element(items, items.begin() + low.count, {},
                             [&](std::int32_t i) { return std::pair(middle(i)[axis], i); });
    constexpr std::int32_t worth_a_task = 1024;
    if (part.count < worth_a_task) {
        sort(boxes, leaf_items, low);
        sort(boxes, leaf_items, high);
    } else {
        tbb::parallel_invoke([&, &half = low] { sort(boxes, leaf_items, half); },
                             [&, &half = high] { sort(boxes, leaf_items, half); });
    }
}

void BoxTree::build(std::span<const WorldBox> boxes, std::int32_t leaf_items, std::size_t node,
                    const Part& items) {
    std::vector<Part> parts = {items};
    for (int turn = 0; turn < 2; ++turn) {
        std::vector<Part> halves;
        for (const Part& part : parts) {
            if (part.count <= leaf_items)
                halves.push_back(part);
            else
                for (const Part& half : halves_of(part, leaf_items)) halves.push_back(half);
        }
        parts = std::move(halves);
    }
    for (std::size_t k = 0; k < parts.size(); ++k) {
        Eigen::AlignedBox3d box;
        for (const std::int32_t i : items_of(parts[k])) {
            const WorldBox& its = boxes[static_cast<std::size_t>(i)];
            box.extend(its.min - middle_).extend(its.max - middle_);
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto lane = static_cast<Eigen::Index>(k);
            const auto i = static_cast<Eigen::Index>(axis);
            nodes_[node].lo[axis][lane] = static_cast<float>(box.min()[i]);
            nodes_[node].hi[axis][lane] = static_cast<float>(box.max()[i]);
        }
        if (parts[k].count <= leaf_items) {
            nodes_[node].parts[k] = parts[k];
            continue;
        }
        const std::size_t child = nodes_.size();
        nodes_.emplace_back();
        nodes_[node].parts[k] = {static_cast<std::int32_t>(child), 0};
        build(boxes, leaf_items, child, parts[k]);
    }
}

} // namespace isocast
