// A kD-tree over the triangles of a mesh: closest point, k nearest, first hit of a ray.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/kd_tree_build.h"
#include "distance_transform/point_triangle.h"

#include <limits>
#include <optional>

namespace isocast {

/// What a query cost; queries add to it.
struct KdStatistics {
    std::int64_t nodes_visited = 0;
    std::int64_t objects_tested = 0;
};

/// Triangles met by a query, so that none is tested twice. Needed where references are split.
class KdMailbox {
public:
    /// True the first time that `triangle` is asked for.
    bool is_new(std::int32_t triangle);

private:
    std::vector<std::int32_t> slots_; // hashed, linear probing, at most half full; -1 is empty
    std::size_t used_ = 0;
};

/// Queries are const and may run on several threads at once.
///
/// source  Sigg 2006 (thesis), 4.1.1
class KdTree {
public:
    struct Nearest {
        ClosestPoint closest;
        std::int32_t triangle;
    };
    struct Hit {
        double t;
        std::int32_t triangle;
    };

    explicit KdTree(const Mesh& mesh, KdVariant variant = KdVariant::Overlapping);

    /// The closest triangle to `p`; of several at the same distance the first of the mesh. Nothing
    /// if all are farther than `greatest_distance`.
    std::optional<Nearest>
    closest(const Vec3d& p, double greatest_distance = std::numeric_limits<double>::infinity(),
            KdStatistics* statistics = nullptr) const;

    /// The `k` closest triangles (or all, if there are fewer) by distance, ties by number.
    std::vector<Nearest> k_nearest(const Vec3d& p, std::size_t k,
                                   KdStatistics* statistics = nullptr) const;

    /// The first triangle, seen from either side, that origin + t * direction meets with 0 <= t <=
    /// greatest_t. Rays do not slip between triangles that share an edge; a triangle in the plane
    /// of the ray, or without area, is not met.
    std::optional<Hit> first_hit(const Vec3d& origin, const Vec3d& direction,
                                 double greatest_t = std::numeric_limits<double>::infinity(),
                                 KdStatistics* statistics = nullptr) const;

    /// Visits triangles depth first, nearer children first.
    ///
    /// can_matter   is asked before each node, with the vector to `p` from the closest point of a
    ///              box that holds the node's triangles: only the component along the split axis
    ///              changes from node to child, and it comes from the plane of that child
    /// at_triangle  is called with number and corners of each triangle of the visited nodes
    template<class CanMatter, class AtTriangle>
    void visit(const Vec3d& p, const CanMatter& can_matter, const AtTriangle& at_triangle,
               KdStatistics* statistics = nullptr) const;

    std::size_t node_count() const { return nodes_.size(); }
    /// Of triangles: more than there are triangles where references are split.
    std::size_t reference_count() const { return triangles_.size(); }

private:
    WorldBox box_;
    std::vector<KdNode> nodes_;
    std::vector<std::int32_t> triangles_;
    std::vector<std::array<Vec3d, 3>> corners_; // of triangles_, where the nodes look for them
    bool has_duplicates_;
};

template<class CanMatter, class AtTriangle>
void KdTree::visit(const Vec3d& p, const CanMatter& can_matter, const AtTriangle& at_triangle,
                   KdStatistics* statistics) const {
    struct Pending {
        Vec3d offset; // from the closest point of the node's box to p
        std::int32_t node;
    };
    // Each level leaves at most one sibling to come back to.
    std::array<Pending, greatest_kd_depth + 1> pending;
    KdMailbox tested;
    pending[0] = {p - p.cwiseMax(box_.min).cwiseMin(box_.max), 0};
    for (int pending_count = 1; pending_count > 0;) {
        auto [offset, index] = pending[--pending_count];
        if (!can_matter(offset)) continue;
        for (;;) {
            const KdNode& node = nodes_[index];
            if (statistics) ++statistics->nodes_visited;
            for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
                if (has_duplicates_ && !tested.is_new(triangles_[i])) continue;
                if (statistics) ++statistics->objects_tested;
                at_triangle(triangles_[i], corners_[i]);
            }
            if (node.right == 0) break;
            // How far p lies outside each child's half space; the far one of the two is for later.
            const double beyond_left = p[node.axis] - node.left_end;
            const double beyond_right = node.right_begin - p[node.axis];
            const double parent = offset[node.axis];
            Vec3d left_offset = offset;
            Vec3d right_offset = offset;
            if (beyond_left > std::max(parent, 0.0)) left_offset[node.axis] = beyond_left;
            if (beyond_right > std::max(-parent, 0.0)) right_offset[node.axis] = -beyond_right;
            const bool left_first = beyond_left <= beyond_right;
            pending[pending_count++] =
                left_first ? Pending{right_offset, node.right} : Pending{left_offset, index + 1};
            offset = left_first ? left_offset : right_offset;
            index = left_first ? index + 1 : node.right;
            if (!can_matter(offset)) break;
        }
    }
}

} // namespace isocast
