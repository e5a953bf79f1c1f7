// Boxes around triangles or points, boxes around these.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/box_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace isocast {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// The middle, twice.
Vec3d middle_of(const WorldBox& box) {
    return box.min + box.max;
}

float rounded_down(double x) {
    const auto rounded = static_cast<float>(x);
    return rounded > x ? std::nextafter(rounded, -infinity) : rounded;
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
    build(boxes, leaf_items, 0, {0, static_cast<std::int32_t>(boxes.size())});
}

void BoxTree::build(std::span<const WorldBox> boxes, std::int32_t leaf_items, std::size_t node,
                    Part items) {
    const auto box_of = [&](std::int32_t i) -> const WorldBox& {
        return boxes[static_cast<std::size_t>(i)];
    };
    const auto items_of = [&](const Part& part) {
        return std::span(order_).subspan(static_cast<std::size_t>(part.first),
                                         static_cast<std::size_t>(part.count));
    };
    std::vector<Part> parts = {items};
    for (int turn = 0; turn < 2; ++turn) {
        std::vector<Part> halves;
        for (const Part& part : parts) {
            if (part.count <= leaf_items) {
                halves.push_back(part);
                continue;
            }
            const std::span<std::int32_t> own = items_of(part);
            Eigen::AlignedBox3d middles;
            for (const std::int32_t i : own) middles.extend(middle_of(box_of(i)));
            int axis = 0;
            middles.sizes().maxCoeff(&axis);
            const std::int32_t half = (part.count / 2 + leaf_items - 1) / leaf_items * leaf_items;
            std::ranges::nth_element(own, own.begin() + half, {}, [&](std::int32_t i) {
                return std::pair(middle_of(box_of(i))[axis], i);
            });
            halves.push_back({part.first, half});
            halves.push_back({part.first + half, part.count - half});
        }
        parts = std::move(halves);
    }
    for (std::size_t k = 0; k < 4; ++k) {
        Eigen::AlignedBox3d box;
        if (k < parts.size())
            for (const std::int32_t i : items_of(parts[k]))
                box.extend(box_of(i).min - middle_).extend(box_of(i).max - middle_);
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            const auto lane = static_cast<Eigen::Index>(k);
            nodes_[node].lo[a][lane] = k < parts.size() ? rounded_down(box.min()[axis]) : infinity;
            nodes_[node].hi[a][lane] =
                k < parts.size() ? -rounded_down(-box.max()[axis]) : -infinity;
        }
        nodes_[node].parts[k] = {0, -1};
        if (k >= parts.size()) continue;
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
