// Exact signed distances at the samples of one block, by recursive culling of its triangles.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/block_transform.h"

#include "distance_transform/band_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

/// A triangle that may be closest to some sample of a node, and what is known at its centre c.
struct Candidate {
    std::size_t triangle; // in the block's list
    double distance;      // of c
    Vec3d closest;        // to c
    Vec3d direction;      // from `closest` to c, unit; 0 where the distance is 0
};

/// One block's descent 8^3 → 4^3 → 2^3 → sample, in voxels from the block's first sample.
///
/// At each node the distances of the kept triangles to its centre c are exact. For a point c' of a
/// child they give, without another distance,
///   d_i(c') >= d_i(c) + u_i · (c' - c), since the distance to a convex set is a convex function
///                                       and u_i is its gradient at c;
///   d_j(c') <= |c' - q_j|,              since q_j is a point of triangle j.
/// A child of radius R needs triangle i only if its lower bound is at most the least upper bound
/// plus 2 R, and at most the half width plus R.
class Descent {
public:
    struct Nearest {
        ClosestPoint closest;
        std::size_t triangle;
    };

    Descent(std::vector<std::array<Vec3d, 3>> corners, double half_width)
        : corners_(std::move(corners)), half_width_(half_width) {}

    /// Calls at_sample(position, nearest) for every sample with a distance within the band.
    template<class AtSample>
    void run(const AtSample& at_sample) {
        const Vec3d centre = Vec3d::Constant((block_size - 1) / 2.0);
        std::vector<Candidate> candidates;
        for (std::size_t i = 0; i < corners_.size(); ++i)
            candidates.push_back(candidate_at(centre, i));
        keep_nearest(candidates, radius_of(block_size));
        descend(Index3::Zero(), block_size, centre, candidates, at_sample);
    }

    std::int64_t evaluations() const { return evaluations_; }

private:
    /// Of the samples of a cube of size^3 about its centre.
    static double radius_of(int size) { return (size - 1) / 2.0 * std::sqrt(3.0); }

    Candidate candidate_at(const Vec3d& centre, std::size_t triangle) {
        ++evaluations_;
        const ClosestPoint found = closest_point(centre, corners_[triangle]);
        const double distance = std::sqrt(found.squared_distance);
        const Vec3d offset = centre - found.p;
        const Vec3d direction = distance > 0 ? Vec3d(offset / distance) : Vec3d::Zero();
        return {triangle, distance, found.p, direction};
    }

    void keep_nearest(std::vector<Candidate>& candidates, double radius) const {
        double bound = half_width_ + radius;
        for (const Candidate& c : candidates) bound = std::min(bound, c.distance + 2 * radius);
        std::erase_if(candidates,
                      [&](const Candidate& c) { return c.distance > bound + culling_slack; });
    }

    /// How far a triangle may lie from `point` and still matter to a node of `radius` about it.
    double reach_at(const Vec3d& point, double radius, std::span<const Candidate> parents) const {
        double least = std::numeric_limits<double>::infinity();
        for (const Candidate& c : parents)
            least = std::min(least, (point - c.closest).squaredNorm());
        return std::min(std::sqrt(least) + 2 * radius, half_width_ + radius) + culling_slack;
    }

    template<class AtSample>
    void descend(const Index3& first, int size, const Vec3d& centre,
                 std::span<const Candidate> parents, const AtSample& at_sample) {
        if (parents.empty()) return;
        const int half = size / 2;
        const double radius = radius_of(half);
        std::vector<Candidate> kept;
        for (int child = 0; child < 8; ++child) {
            const Index3 child_first = first + half * Index3(child & 1, child >> 1 & 1, child >> 2);
            const Vec3d point = child_first.cast<double>() + Vec3d::Constant((half - 1) / 2.0);
            const Vec3d offset = point - centre;
            const double reach = reach_at(point, radius, parents);
            const auto can_matter = [&](const Candidate& c) {
                return c.distance + c.direction.dot(offset) <= reach;
            };
            if (half == 1) {
                visit_sample(child_first, point, parents, can_matter, at_sample);
                continue;
            }
            kept.clear();
            for (const Candidate& c : parents)
                if (can_matter(c)) kept.push_back(candidate_at(point, c.triangle));
            keep_nearest(kept, radius);
            descend(child_first, half, point, kept, at_sample);
        }
    }

    template<class CanMatter, class AtSample>
    void visit_sample(const Index3& index, const Vec3d& point, std::span<const Candidate> parents,
                      const CanMatter& can_matter, const AtSample& at_sample) {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        Nearest nearest{{Vec3d::Zero(), infinity, Feature::Face}, 0};
        for (const Candidate& c : parents) {
            if (!can_matter(c)) continue;
            ++evaluations_;
            const ClosestPoint found = closest_point(point, corners_[c.triangle]);
            if (found.squared_distance < nearest.closest.squared_distance)
                nearest = {found, c.triangle};
        }
        if (std::sqrt(nearest.closest.squared_distance) <= half_width_) at_sample(index, nearest);
    }

    std::vector<std::array<Vec3d, 3>> corners_; // in voxels from the block's first sample
    double half_width_;
    std::int64_t evaluations_ = 0;
};

/// The band's border [voxels] is this much wider than asked, far above rounding: samples exactly on
/// it are all active, and the neighbours of an inactive sample are surely not on the surface.
constexpr double border_slack = 1e-9;

int sample_index(const Index3& p) {
    return p.x() + block_size * (p.y() + block_size * p.z());
}

} // namespace

std::int64_t BlockTransform::run(FieldBlock& block, std::span<const int> triangles) const {
    const Vec3d origin = block_size * block.coordinate.cast<double>();
    std::vector<std::array<Vec3d, 3>> corners;
    corners.reserve(triangles.size());
    for (const int triangle : triangles) {
        const auto [a, b, c] = mesh_.triangles[triangle];
        corners.push_back({mesh_.vertices_world[a] - origin, mesh_.vertices_world[b] - origin,
                           mesh_.vertices_world[c] - origin});
    }
    Descent descent(std::move(corners), half_width_ + border_slack);
    descent.run([&](const Index3& index, const Descent::Nearest& nearest) {
        const ClosestPoint& closest = nearest.closest;
        const Vec3d point = index.cast<double>();
        bool is_inside = false;
        if (const auto* normals = std::get_if<Pseudonormals>(&sign_))
            is_inside =
                (point - closest.p).dot(normals->at(triangles[nearest.triangle], closest.feature)) <
                0;
        else
            is_inside = std::get<WindingNumber>(sign_).is_inside(origin + point);
        const double distance =
            voxel_size_ * std::min(std::sqrt(closest.squared_distance), half_width_);
        const int i = sample_index(index);
        block.values[i] = static_cast<float>(is_inside ? -distance : distance);
        block.active[i] = true;
    });
    spread_signs(block, static_cast<float>(voxel_size_ * half_width_));
    return descent.evaluations();
}

void spread_signs(FieldBlock& block, float background_world) {
    std::vector<Index3> reached;
    std::bitset<samples_per_block> is_known = block.active;
    for (int i = 0; i < samples_per_block; ++i)
        if (block.active[i])
            reached.emplace_back(i % block_size, i / block_size % block_size,
                                 i / (block_size * block_size));
    for (std::size_t next = 0; next < reached.size(); ++next) {
        const float sign = block.values[sample_index(reached[next])];
        for (int k = 0; k < 6; ++k) {
            Index3 neighbour = reached[next];
            neighbour[k / 2] += k % 2 == 0 ? -1 : 1;
            if ((neighbour.array() < 0).any() || (neighbour.array() >= block_size).any()) continue;
            const int i = sample_index(neighbour);
            if (is_known[i]) continue;
            is_known[i] = true;
            block.values[i] = std::copysign(background_world, sign);
            reached.push_back(neighbour);
        }
    }
}

} // namespace isocast
