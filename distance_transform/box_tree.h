// Boxes around triangles, boxes around these: what far points ask.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace isocast {

/// A binary tree of boxes over triangles, halved by number along the longest side.
///
/// The nodes of KdTree (thesis 4.1) are bounded by a plane a level, those here on all six sides:
/// points far from the surface see a few per cent of the triangles.
class BoxTree {
public:
    explicit BoxTree(std::span<const std::array<Vec3d, 3>> triangles);

    /// Visits triangles, the nearer boxes first.
    ///
    /// can_matter   is asked before each box, with the vector to `p` from its closest point
    /// at_triangle  is called with the number of each triangle of the boxes that can matter
    template<class CanMatter, class AtTriangle>
    void visit(const Vec3d& p, const CanMatter& can_matter, const AtTriangle& at_triangle) const;

private:
    struct Node {
        Vec3d lo;
        Vec3d hi;
        std::int32_t right; // the left child is next; 0 in leaves
        std::int32_t first; // of a leaf's triangles
        std::int32_t count;

        Vec3d offset_to(const Vec3d& p) const { return p - p.cwiseMax(lo).cwiseMin(hi); }
    };
    void build(std::span<const std::array<Vec3d, 3>> triangles, std::int32_t first,
               std::int32_t count);

    std::vector<Node> nodes_;
    std::vector<std::int32_t> order_;
};

template<class CanMatter, class AtTriangle>
void BoxTree::visit(const Vec3d& p, const CanMatter& can_matter,
                    const AtTriangle& at_triangle) const {
    struct Pending {
        Vec3d offset;
        std::int32_t node;
    };
    std::array<Pending, 64> pending; // halving 2^31 triangles leaves one a level
    pending[0] = {nodes_[0].offset_to(p), 0};
    for (int pending_count = 1; pending_count > 0;) {
        auto [offset, index] = pending[static_cast<std::size_t>(--pending_count)];
        while (can_matter(offset)) {
            const Node& node = nodes_[static_cast<std::size_t>(index)];
            if (node.right == 0) {
                for (std::int32_t i = node.first; i < node.first + node.count; ++i)
                    at_triangle(order_[static_cast<std::size_t>(i)]);
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
