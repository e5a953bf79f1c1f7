// Boxes around triangles or points, boxes around these: what is nearest to a place.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace isocast {

/// A tree of boxes over items, each around up to four: halved by number along the longest side, and
/// the halves once more.
///
/// The nodes of KdTree (thesis 4.1) are bounded by a plane a level, those here on all six sides:
/// points far from the surface see a few per cent of the triangles. Four boxes are looked at at
/// once, in float, about the middle of all; `rounding` and a pad around p see that none is missed.
class BoxTree {
public:
    /// boxes       of the items, fewer than 2^31; empty ones are not allowed
    /// leaf_items  that a leaf holds; the last one may hold fewer
    BoxTree(std::span<const WorldBox> boxes, std::int32_t leaf_items);

    /// The items' numbers by their places: a leaf's items stand together.
    std::span<const std::int32_t> order() const { return order_; }

    /// Visits leaves whose boxes come near p, nearer ones first.
    ///
    /// squared_reach  tells how far away a box may be; it may shrink
    /// at_leaf        is called with the places first … end - 1; first is a multiple of leaf_items
    template<class SquaredReach, class AtLeaf>
    void visit_near(const Vec3d& p, const SquaredReach& squared_reach, const AtLeaf& at_leaf) const;
    /// Visits leaves whose boxes touch the cube of the points at most `half_edge` from p along each
    /// axis, while goes_on().
    template<class GoesOn, class AtLeaf>
    void visit_touching(const Vec3d& p, double half_edge, const GoesOn& goes_on,
                        const AtLeaf& at_leaf) const;

private:
    using Floats = Eigen::Array4f;
    /// Items `first`, `first` + 1, … of a leaf; where `count` is 0, the node `first`; where it is
    /// negative, nothing.
    struct Part {
        std::int32_t first = 0;
        std::int32_t count = -1;
    };
    struct Node {
        std::array<Floats, 3> lo, hi; // by axis, from the middle; of four parts
        std::array<Part, 4> parts;
    };
    /// A point between two floats on each axis.
    struct Place {
        std::array<float, 3> lo, hi;
    };
    /// Parts that are pending at most: three a level, of 2^31 items that are halved twice a level.
    static constexpr std::size_t most_pending = 64;
    /// More than the seven roundings of 2^-24 that a squared distance has.
    static constexpr double rounding = 1e-6;

    std::span<std::int32_t> items_of(const Part& part);
    /// Where a part is parted: all leaves but the last are full.
    static std::array<Part, 2> halves_of(const Part& part, std::int32_t leaf_items);
    void sort(std::span<const WorldBox> boxes, std::int32_t leaf_items, const Part& part);
    void build(std::span<const WorldBox> boxes, std::int32_t leaf_items, std::size_t node,
               const Part& items);
    Place place_of(const Vec3d& p) const {
        Place place;
        for (int axis = 0; axis < 3; ++axis) {
            const auto x = static_cast<float>(p[axis] - middle_[axis]);
            // x is off by a quarter of it, a box there by another.
            const float pad = std::abs(x) * 0x1p-22F;
            place.lo[static_cast<std::size_t>(axis)] = x - pad;
            place.hi[static_cast<std::size_t>(axis)] = x + pad;
        }
        return place;
    }
    static Floats along(const Node& node, const Place& p, std::size_t axis) {
        return (node.lo[axis] - p.hi[axis]).max(p.lo[axis] - node.hi[axis]);
    }

    Vec3d middle_ = Vec3d::Zero();
    std::vector<Node> nodes_; // the root first
    std::vector<std::int32_t> order_;
};

template<class SquaredReach, class AtLeaf>
void BoxTree::visit_near(const Vec3d& p, const SquaredReach& squared_reach,
                         const AtLeaf& at_leaf) const {
    if (nodes_.empty()) return;
    const Place place = place_of(p);
    const auto reach = [&] {
        return std::max(static_cast<float>(squared_reach() * (1 + rounding)),
                        std::numeric_limits<float>::min());
    };
    struct Pending {
        float squared_distance;
        Part part;
    };
    std::array<Pending, most_pending> pending;
    pending[0] = {0, {0, 0}};
    float greatest = reach();
    for (std::size_t pending_count = 1; pending_count > 0;) {
        const auto [nearest, part] = pending[--pending_count];
        if (!(nearest <= greatest)) continue;
        if (part.count > 0) {
            at_leaf(part.first, part.first + part.count);
            greatest = reach();
            continue;
        }
        const Node& node = nodes_[static_cast<std::size_t>(part.first)];
        const Floats squared = along(node, place, 0).max(0).square() +
                               along(node, place, 1).max(0).square() +
                               along(node, place, 2).max(0).square();
        // Nearer ones are put on top.
        const std::size_t first = pending_count;
        for (std::size_t k = 0; k < 4; ++k) {
            const float its = squared[static_cast<Eigen::Index>(k)];
            if (!(its <= greatest) || node.parts[k].count < 0) continue;
            std::size_t at = pending_count++;
            for (; at > first && pending[at - 1].squared_distance < its; --at)
                pending[at] = pending[at - 1];
            pending[at] = {its, node.parts[k]};
        }
    }
}

template<class GoesOn, class AtLeaf>
void BoxTree::visit_touching(const Vec3d& p, double half_edge, const GoesOn& goes_on,
                             const AtLeaf& at_leaf) const {
    if (nodes_.empty()) return;
    const Place place = place_of(p);
    const auto greatest = static_cast<float>(half_edge * (1 + rounding));
    std::array<Part, most_pending> pending;
    pending[0] = {0, 0};
    for (std::size_t pending_count = 1; pending_count > 0 && goes_on();) {
        const Part part = pending[--pending_count];
        if (part.count > 0) {
            at_leaf(part.first, part.first + part.count);
            continue;
        }
        const Node& node = nodes_[static_cast<std::size_t>(part.first)];
        const Floats apart =
            along(node, place, 0).max(along(node, place, 1)).max(along(node, place, 2));
        for (std::size_t k = 0; k < 4; ++k)
            if (apart[static_cast<Eigen::Index>(k)] <= greatest && node.parts[k].count >= 0)
                pending[pending_count++] = node.parts[k];
    }
}

} // namespace isocast
