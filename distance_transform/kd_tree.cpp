// Queries of a kD-tree: closest point, k nearest, first hit of a ray.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/kd_tree.h"

#include "volume/assert.h"

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Relative widening of a node's interval of a ray, above the rounding of three operations.
constexpr double ray_slack = 0x1p-50;

bool is_closer(const KdTree::Nearest& a, const KdTree::Nearest& b) {
    return std::pair(a.closest.squared_distance, a.triangle) <
           std::pair(b.closest.squared_distance, b.triangle);
}

/// Watertight: seen along the ray the sign of an edge's product is right or 0 for the sheared
/// corners, since rounding keeps order, and triangles that share a corner share its sheared place.
/// So of those around an edge or a vertex that the ray meets at least one is hit.
///
/// source  Woop, Benthin & Wald 2013
class ShearedRay {
public:
    ShearedRay(const Vec3d& origin, const Vec3d& direction) : origin_(origin) {
        direction.cwiseAbs().maxCoeff(&along_);
        shear_ = direction / direction[along_];
        scale_ = 1 / direction[along_];
    }

    std::optional<double> hit(const std::array<Vec3d, 3>& corners) const {
        const Vec3d a = sheared(corners[0]);
        const Vec3d b = sheared(corners[1]);
        const Vec3d c = sheared(corners[2]);
        const double weight_a = c.x() * b.y() - c.y() * b.x();
        const double weight_b = a.x() * c.y() - a.y() * c.x();
        const double weight_c = b.x() * a.y() - b.y() * a.x();
        const bool is_positive = weight_a >= 0 && weight_b >= 0 && weight_c >= 0;
        const bool is_negative = weight_a <= 0 && weight_b <= 0 && weight_c <= 0;
        const double area = weight_a + weight_b + weight_c;
        if (!(is_positive || is_negative) || area == 0) return std::nullopt;
        const double t = scale_ * (weight_a * a.z() + weight_b * b.z() + weight_c * c.z()) / area;
        if (!(t >= 0)) return std::nullopt;
        return t;
    }

private:
    /// From the origin, z along the axis that the ray follows most.
    Vec3d sheared(const Vec3d& corner) const {
        const Vec3d p = corner - origin_;
        const int x = (along_ + 1) % 3;
        const int y = (along_ + 2) % 3;
        return {p[x] - shear_[x] * p[along_], p[y] - shear_[y] * p[along_], p[along_]};
    }

    Vec3d origin_;
    Vec3d shear_;
    double scale_;
    int along_ = 0;
};

/// The part of a ray within a box, or within a half space of it.
struct Interval {
    double begin;
    double end;

    void clip_below(double plane, double origin, double direction) {
        if (direction == 0) {
            if (origin > plane) end = -infinity;
        } else {
            clip(plane, origin, direction, direction > 0);
        }
    }
    void clip_above(double plane, double origin, double direction) {
        if (direction == 0) {
            if (origin < plane) end = -infinity;
        } else {
            clip(plane, origin, direction, direction < 0);
        }
    }

private:
    void clip(double plane, double origin, double direction, bool is_end) {
        const double t = (plane - origin) / direction;
        if (is_end)
            end = std::min(end, t + ray_slack * std::abs(t));
        else
            begin = std::max(begin, t - ray_slack * std::abs(t));
    }
};

} // namespace

bool KdMailbox::is_new(std::int32_t triangle) {
    if (2 * used_ >= slots_.size()) {
        std::vector<std::int32_t> old(std::max<std::size_t>(64, 2 * slots_.size()), -1);
        old.swap(slots_);
        used_ = 0;
        for (const std::int32_t t : old)
            if (t >= 0) is_new(t);
    }
    // Sizes are powers of two; Knuth's multiplier spreads neighbouring numbers.
    std::size_t slot = (static_cast<std::uint32_t>(triangle) * 2654435769u) >> 8;
    for (;; ++slot) {
        std::int32_t& found = slots_[slot & (slots_.size() - 1)];
        if (found == triangle) return false;
        if (found >= 0) continue;
        found = triangle;
        ++used_;
        return true;
    }
}

KdTree::KdTree(const Mesh& mesh, KdVariant variant) : box_(bounding_box(mesh)) {
    KdNodes built = build_kd_nodes(mesh, variant);
    nodes_ = std::move(built.nodes);
    triangles_ = std::move(built.triangles);
    has_duplicates_ = triangles_.size() > mesh.triangles.size();
    corners_.reserve(triangles_.size());
    for (const std::int32_t t : triangles_) {
        const auto [a, b, c] = mesh.triangles[t];
        corners_.push_back(
            {mesh.vertices_world[a], mesh.vertices_world[b], mesh.vertices_world[c]});
    }
}

std::optional<KdTree::Nearest> KdTree::closest(const Vec3d& p, double greatest_distance,
                                               KdStatistics* statistics) const {
    Nearest best{{Vec3d::Zero(), greatest_distance * greatest_distance, Feature::Face},
                 std::numeric_limits<std::int32_t>::max()};
    bool is_found = false;
    visit(
        p,
        [&](const Vec3d& offset) { return offset.squaredNorm() <= best.closest.squared_distance; },
        [&](std::int32_t triangle, const std::array<Vec3d, 3>& corners) {
            const Nearest found{closest_point(p, corners), triangle};
            if (!is_closer(found, best)) return;
            best = found;
            is_found = true;
        },
        statistics);
    if (!is_found) return std::nullopt;
    return best;
}

std::vector<KdTree::Nearest> KdTree::k_nearest(const Vec3d& p, std::size_t k,
                                               KdStatistics* statistics) const {
    std::vector<Nearest> nearest; // a heap, the farthest in front
    if (k == 0) return nearest;
    visit(
        p,
        [&](const Vec3d& offset) {
            return nearest.size() < k ||
                   offset.squaredNorm() <= nearest.front().closest.squared_distance;
        },
        [&](std::int32_t triangle, const std::array<Vec3d, 3>& corners) {
            const Nearest found{closest_point(p, corners), triangle};
            if (nearest.size() == k) {
                if (!is_closer(found, nearest.front())) return;
                std::ranges::pop_heap(nearest, is_closer);
                nearest.pop_back();
            }
            nearest.push_back(found);
            std::ranges::push_heap(nearest, is_closer);
        },
        statistics);
    std::ranges::sort_heap(nearest, is_closer);
    return nearest;
}

std::optional<KdTree::Hit> KdTree::first_hit(const Vec3d& origin, const Vec3d& direction,
                                             double greatest_t, KdStatistics* statistics) const {
    struct Pending {
        Interval interval;
        std::int32_t node;
    };
    std::array<Pending, greatest_kd_depth + 1> pending;
    KdMailbox tested;
    const ShearedRay ray(origin, direction);
    Hit best{greatest_t, std::numeric_limits<std::int32_t>::max()};
    bool is_found = false;
    pending[0] = {{0, infinity}, 0};
    for (int k = 0; k < 3; ++k) {
        pending[0].interval.clip_below(box_.max[k], origin[k], direction[k]);
        pending[0].interval.clip_above(box_.min[k], origin[k], direction[k]);
    }
    for (int pending_count = 1; pending_count > 0;) {
        const auto [interval, index] = pending[--pending_count];
        if (interval.begin > std::min(interval.end, best.t)) continue;
        const KdNode& node = nodes_[index];
        if (statistics) ++statistics->nodes_visited;
        for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
            if (has_duplicates_ && !tested.is_new(triangles_[i])) continue;
            if (statistics) ++statistics->objects_tested;
            const std::optional<double> t = ray.hit(corners_[i]);
            if (!t || std::pair(*t, triangles_[i]) >= std::pair(best.t, best.triangle)) continue;
            best = {*t, triangles_[i]};
            is_found = true;
        }
        if (node.right == 0) continue;
        ISOCAST_ASSERT(pending_count + 2 <= std::ssize(pending), "%d pending", pending_count);
        Pending left{interval, index + 1};
        Pending right{interval, node.right};
        left.interval.clip_below(node.left_end, origin[node.axis], direction[node.axis]);
        right.interval.clip_above(node.right_begin, origin[node.axis], direction[node.axis]);
        const bool left_first = direction[node.axis] >= 0;
        pending[pending_count++] = left_first ? right : left;
        pending[pending_count++] = left_first ? left : right;
    }
    if (!is_found) return std::nullopt;
    return best;
}

} // namespace isocast
