// A tree over points: the nearest ones to a place, and those within a radius of it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/box_tree.h"

#include <compare>

namespace isocast {

/// A point of a cloud as seen from some place.
struct Neighbour {
    double squared_distance;
    std::int32_t point;

    auto operator<=>(const Neighbour&) const = default; // by distance, ties by number
};

/// Queries are const and may run on several threads at once; they write to `found`, whose memory is
/// used again.
class PointTree {
public:
    /// points  finite, fewer than 2^31; they need not outlive the tree
    explicit PointTree(std::span<const Vec3d> points);

    /// The `count` nearest points (or all, if there are fewer), nearest first, ties by number.
    void nearest(const Vec3d& p, std::size_t count, std::vector<Neighbour>& found) const;
    /// All points at most `radius` away, in the tree's order.
    void within(const Vec3d& p, double radius, std::vector<Neighbour>& found) const;

private:
    /// Visits the points of boxes at most sqrt(greatest()) away, nearer boxes first.
    template<class Greatest, class AtPoint>
    void visit(const Vec3d& p, const Greatest& greatest, const AtPoint& at_point) const;

    BoxTree tree_;
    std::vector<Vec3d> points_; // in its order
};

} // namespace isocast
