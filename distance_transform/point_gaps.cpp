// The surface w = 1/2 is followed through cubes without points, from beside the cloud on.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/point_gaps.h"

#include "distance_transform/point_tree.h"
#include "volume/index_hash.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

namespace isocast {

namespace {

/// Sorted by z, y, x, each once.
using Cells = std::vector<Index3>;

void sort_and_unite(Cells& cells) {
    std::ranges::sort(cells, zyx_less);
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
}

template<class Visit>
void for_each_around(const Index3& cell, const Visit& visit) {
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) visit(Index3(cell + Index3(x, y, z)));
}

Cells grown(const Cells& cells) {
    Cells result;
    result.reserve(27 * cells.size());
    for (const Index3& cell : cells)
        for_each_around(cell, [&](const Index3& next) { result.push_back(next); });
    sort_and_unite(result);
    return result;
}

bool contains(const Cells& cells, const Index3& cell) {
    return std::ranges::binary_search(cells, cell, zyx_less);
}

class GapSurface {
public:
    GapSurface(std::span<const Vec3d> points, std::span<const double> spacing, double cell,
               const WindingNumber& winding)
        : spacing_(spacing), tree_(points), cell_(cell), winding_(winding), origin_(points[0]),
          last_(points[0]) {
        for (const Vec3d& p : points) {
            origin_ = origin_.cwiseMin(p);
            last_ = last_.cwiseMax(p);
        }
        Cells occupied;
        for (const Vec3d& p : points)
            occupied.push_back(((p - origin_) / cell_).array().floor().cast<int>());
        sort_and_unite(occupied);
        beside_points_ = grown(occupied);
    }

    PointCloud points() {
        PointCloud found;
        Cells front;
        std::ranges::set_difference(grown(beside_points_), beside_points_,
                                    std::back_inserter(front), zyx_less);
        std::erase_if(front, [&](const Index3& cell) { return !is_in_box(cell); });
        std::unordered_set<Index3, IndexHash> seen(front.begin(), front.end());
        while (!front.empty()) {
            ask_at_corners(front);
            Cells next;
            for (const Index3& cell : front) {
                if (!is_cut(cell)) continue;
                add_point(cell, found);
                for_each_around(cell, [&](const Index3& other) {
                    if (is_in_box(other) && !contains(beside_points_, other) &&
                        seen.insert(other).second)
                        next.push_back(other);
                });
            }
            sort_and_unite(next);
            front = std::move(next);
        }
        return found;
    }

private:
    Vec3d corner(const Index3& node) const { return origin_ + cell_ * node.cast<double>(); }
    /// Of the points, and a cell around it.
    bool is_in_box(const Index3& cell) const {
        const Vec3d middle = corner(cell).array() + cell_ / 2;
        return (middle.array() > origin_.array() - cell_).all() &&
               (middle.array() < last_.array() + cell_).all();
    }

    /// Of w - 1/2, in parallel.
    void ask_at_corners(const Cells& cells) {
        Cells nodes;
        for (const Index3& cell : cells)
            for (int i = 0; i < 8; ++i) {
                const Index3 node = cell + Index3(i & 1, i >> 1 & 1, i >> 2);
                if (!excess_.contains(node)) nodes.push_back(node);
            }
        sort_and_unite(nodes);
        std::vector<double> values(nodes.size());
        tbb::parallel_for(std::size_t{0}, nodes.size(),
                          [&](std::size_t i) { values[i] = winding_.at(corner(nodes[i])) - 0.5; });
        for (std::size_t i = 0; i < nodes.size(); ++i) excess_[nodes[i]] = values[i];
    }
    double excess(const Index3& cell, int i) const {
        return excess_.at(cell + Index3(i & 1, i >> 1 & 1, i >> 2));
    }
    bool is_cut(const Index3& cell) const {
        for (int i = 1; i < 8; ++i)
            if ((excess(cell, i) > 0) != (excess(cell, 0) > 0)) return true;
        return false;
    }

    /// In the middle of where the surface cuts the cell's edges, then moved onto it; unless the
    /// cloud is near, or a point that was found before.
    void add_point(const Index3& cell, PointCloud& found) {
        Vec3d sum = Vec3d::Zero();
        int cuts = 0;
        for (int i = 0; i < 8; ++i) {
            for (int bit = 1; bit < 8; bit *= 2) {
                const double a = excess(cell, i);
                const double b = excess(cell, i | bit);
                if ((i & bit) != 0 || (a > 0) == (b > 0)) continue;
                const Vec3d offset(i & 1, i >> 1 & 1, i >> 2);
                sum += offset + a / (a - b) * Vec3d(bit & 1, bit >> 1 & 1, bit >> 2);
                ++cuts;
            }
        }
        Vec3d p = corner(cell) + cell_ * sum / cuts;
        Vec3d gradient;
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3d step = cell_ / 2 * Vec3d::Unit(axis);
            gradient[axis] = (winding_.at(p + step) - winding_.at(p - step)) / cell_;
        }
        const double square = gradient.squaredNorm();
        const Vec3d move = (0.5 - winding_.at(p)) / square * gradient;
        if (!(square > 0) || !(move.norm() < cell_)) return;
        p += move;
        tree_.nearest(p, 1, nearest_);
        const double spacing = spacing_[static_cast<std::size_t>(nearest_[0].point)];
        if (nearest_[0].squared_distance < std::max(cell_ * cell_, 4 * spacing * spacing)) return;
        const Index3 home = ((p - origin_) / cell_).array().floor().cast<int>();
        bool is_near_another = false;
        for_each_around(home, [&](const Index3& other) {
            const auto [first, last] = homes_.equal_range(other);
            for (auto it = first; it != last; ++it)
                is_near_another |=
                    (found.points_world[it->second] - p).squaredNorm() < cell_ * cell_ / 4;
        });
        if (is_near_another) return;
        homes_.emplace(home, found.points_world.size());
        found.points_world.push_back(p);
        found.normals.push_back(-gradient / std::sqrt(square));
    }

    std::span<const double> spacing_;
    PointTree tree_;
    double cell_;
    const WindingNumber& winding_;
    Vec3d origin_; // least and greatest of the points
    Vec3d last_;
    Cells beside_points_;
    std::unordered_map<Index3, double, IndexHash> excess_;          // w - 1/2
    std::unordered_multimap<Index3, std::size_t, IndexHash> homes_; // of the points found
    std::vector<Neighbour> nearest_;
};

} // namespace

PointCloud points_over_gaps(std::span<const Vec3d> points, std::span<const double> spacing,
                            double cell, const WindingNumber& winding) {
    return GapSurface(points, spacing, cell, winding).points();
}

} // namespace isocast
