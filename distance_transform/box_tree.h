// Boxes around triangles or points, boxes around these: what is nearest to a place.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace isocast {

/// A binary tree of boxes over items, halved by number along the longest side.
///
/// The nodes of KdTree (thesis 4.1) are bounded by a plane a level, those here on all six sides:
/// points far from the surface see a few per cent of the triangles.
class BoxTree {
public:
    /// boxes       of the items, fewer than 2^31; empty ones are not allowed
    /// leaf_items  that a leaf holds at most
    BoxTree(std::span<const WorldBox> boxes, std::int32_t leaf_items);

    /// The items' numbers by their places: a leaf's items stand together.
    std::span<const std::int32_t> order() const { return order_; }

    /// Visits items, those of nearer boxes first.
    ///
    /// can_matter  is asked before each box, with the vector to `p` from its closest point
    /// at_place    is called with the place of each item of the boxes that can matter
    template<class CanMatter, class AtPlace>
    void visit(const Vec3d& p, const CanMatter& can_matter, const AtPlace& at_place) const;

private:
    struct Node {
        WorldBox box;
        std::int32_t right; // the left child is next; 0 in leaves
        std::int32_t first; // of a leaf's places
        std::int32_t count;

        Vec3d offset_to(const Vec3d& p) const { return p - p.cwiseMax(box.min).cwiseMin(box.max); }
    };
    void build(std::span<const WorldBox> boxes, std::int32_t leaf_items, std::int32_t first,
               std::int32_t count);

    std::vector<Node> nodes_; // in depth-first order
    std::vector<std::int32_t> order_;
};

template<class CanMatter, class AtPlace>
void BoxTree::visit(const Vec3d& p, const CanMatter& can_matter, const AtPlace& at_place) const {
    if (nodes_.empty()) return;
    struct Pending {
        Vec3d offset;
        std::int32_t node;
    };
    std::array<Pending, 64> pending; // halving 2^31 items leaves one a level
    pending[0] = {nodes_[0].offset_to(p), 0};
    for (int pending_count = 1; pending_count > 0;) {
        auto [offset, index] = pending[static_cast<std::size_t>(--pending_count)];
        while (can_matter(offset)) {
            const Node& node = nodes_[static_cast<std::size_t>(index)];
            if (node.right == 0) {
                for (std::int32_t i = node.first; i < node.first + node.count; ++i) at_place(i);
                break;
            }
            const Vec3d left = nodes_[static_cast<std::size_t>(index) + 1].offset_to(p);
            const Vec3d right = nodes_[static_cast<std::size_t>(node.right)].offset_to(p);
            const bool left_first = left.squaredNorm() <= right.squaredNorm();
            pending[static_cast<std::size_t>(pending_count++)] =
                left_first ? Pending{right, node.right} : Pending{left, index + 1};
            offset = left_first ? left : right;
            index = left_first ? index + 1 : node.right;
        }
    }
}

} // namespace isocast
