// SPDX-License-Identifier: MPL-2.0
#include "quadrics/scatter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>

namespace isocast {

namespace {

constexpr std::size_t candidates_per_point = 5;
constexpr double limit_share = 0.65; // beta
constexpr double limit_power = 1.5;  // gamma

/// From 0 to 1, without 1; unlike std::uniform_real_distribution the same in every library.
double uniform(std::mt19937_64& random) {
    return static_cast<double>(random() >> 11) * 0x1p-53;
}

/// Random points, one in each of `count` equal parts of the area.
std::vector<SurfacePoint> candidates_of(std::span<const Vec3d> vertices,
                                        std::span<const Eigen::Vector3i> triangles,
                                        std::span<const double> area_up_to, std::size_t count,
                                        std::mt19937_64& random) {
    std::vector<SurfacePoint> points;
    points.reserve(count);
    const double total = area_up_to.back();
    // The first that reaches the total: those behind it have no area.
    const auto last = std::lower_bound(area_up_to.begin(), area_up_to.end(), total);
    for (std::size_t k = 0; k < count; ++k) {
        const double at =
            (static_cast<double>(k) + uniform(random)) / static_cast<double>(count) * total;
        // The first triangle beyond `at` is larger than nothing.
        const auto found =
            std::min(std::upper_bound(area_up_to.begin(), area_up_to.end(), at), last);
        const auto triangle = static_cast<std::size_t>(found - area_up_to.begin());
        // Uniform over a triangle: by its height the square root, by its width plain.
        const double height = std::sqrt(uniform(random));
        const double width = uniform(random);
        const Vec3d barycentric(1 - height, height * (1 - width), height * width);
        Vec3d position = Vec3d::Zero();
        for (int c = 0; c < 3; ++c)
            position += barycentric[c] * vertices[static_cast<std::size_t>(triangles[triangle][c])];
        points.push_back({position, static_cast<int>(triangle), barycentric});
    }
    return points;
}

/// Finds points by cubic cells as large as the reach of a search. It numbers them by cell, so that
/// neighbours lie close in memory.
class Cells {
public:
    Cells(std::span<const SurfacePoint> points, double reach) : reach_(reach) {
        Eigen::AlignedBox3d box;
        for (const SurfacePoint& p : points) box.extend(p.position_world);
        lo_ = box.min();
        // At most 2^20 cells along each axis, so that three numbers fit into one key.
        size_ = std::max(reach, box.sizes().maxCoeff() * 0x1p-20);
        std::vector<std::pair<std::uint64_t, std::size_t>> order;
        order.reserve(points.size());
        for (std::size_t i = 0; i < points.size(); ++i)
            order.emplace_back(key_of(cell_of(points[i].position_world)), i);
        std::sort(order.begin(), order.end());
        std::vector<std::uint64_t> keys;
        for (const auto& [key, i] : order) {
            if (keys.empty() || keys.back() != key) {
                keys.push_back(key);
                firsts_.push_back(points_.size());
            }
            points_.push_back(points[i].position_world);
            original_.push_back(i);
            cell_.push_back(keys.size() - 1);
        }
        firsts_.push_back(points_.size());
        // A row of three cells along z is one range of keys, hence of points.
        rows_.resize(keys.size());
        tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t c) {
            const auto index_of = [&](auto found) {
                return firsts_[static_cast<std::size_t>(found - keys.begin())];
            };
            const Cell cell = cell_of(points_[firsts_[c]]);
            for (int row = 0; row < 9; ++row) {
                const std::int64_t x = cell.x() + row / 3 - 1, y = cell.y() + row % 3 - 1;
                const auto from =
                    std::lower_bound(keys.begin(), keys.end(), key_of({x, y, cell.z() - 1}));
                const auto to = std::upper_bound(from, keys.end(), key_of({x, y, cell.z() + 1}));
                rows_[c][static_cast<std::size_t>(row)] = {index_of(from), index_of(to)};
            }
        });
    }
    std::size_t original(std::size_t i) const { return original_[i]; }

    /// Calls visit(j, distance) for each other point within reach of point i, in a fixed order.
    template<class Visit>
    void each_near(std::size_t i, Visit visit) const {
        const Vec3d& p = points_[i];
        for (const Range& row : rows_[cell_[i]])
            for (std::size_t j = row.from; j < row.to; ++j) {
                const double distance = (points_[j] - p).norm();
                if (j != i && distance < reach_) visit(j, distance);
            }
    }

private:
    using Cell = Eigen::Matrix<std::int64_t, 3, 1>;
    Cell cell_of(const Vec3d& p) const {
        return ((p - lo_) / size_).array().floor().matrix().cast<std::int64_t>();
    }
    static std::uint64_t key_of(const Cell& cell) { // from 1, as neighbours begin at -1
        const Eigen::Matrix<std::uint64_t, 3, 1> c = (cell.array() + 1).cast<std::uint64_t>();
        return c.x() << 42 | c.y() << 21 | c.z();
    }

    double reach_ = 0;
    double size_ = 0;
    Vec3d lo_;
    struct Range {
        std::size_t from, to;
    };
    std::vector<Vec3d> points_;
    std::vector<std::size_t> original_;
    std::vector<std::size_t> cell_;          // of each point
    std::vector<std::size_t> firsts_;        // points of each cell, and the end
    std::vector<std::array<Range, 9>> rows_; // of each cell: points in it and around
};

/// A heap that knows where each item is: the heaviest is on top, of equals the one of least rank.
/// Entries hold all that comparisons need, since looking it up elsewhere would take most of the
/// time.
class HeaviestFirst {
public:
    HeaviestFirst(std::span<const double> weights, std::span<const std::uint32_t> ranks)
        : place_(weights.size()) {
        for (std::size_t i = 0; i < weights.size(); ++i)
            heap_.push_back({weights[i], ranks[i], static_cast<std::uint32_t>(i)});
        for (std::uint32_t i = 0; i < heap_.size(); ++i) place_[i] = i;
        for (std::size_t at = heap_.size() / 2; at-- > 0;) sink(at, heap_[at]);
    }
    std::size_t size() const { return heap_.size(); }
    bool holds(std::size_t item) const { return place_[item] != none; }
    std::size_t take() {
        const std::uint32_t top = heap_.front().item;
        const Entry last = heap_.back();
        heap_.pop_back();
        if (!heap_.empty()) sink(0, last);
        place_[top] = none;
        return top;
    }
    void lighten(std::size_t item, double by) {
        const std::size_t at = place_[item];
        Entry entry = heap_[at];
        entry.weight -= by;
        sink(at, entry);
    }

private:
    struct Entry {
        double weight;
        std::uint32_t rank, item;
    };
    static constexpr std::uint32_t none = ~std::uint32_t{0};
    static bool is_before(const Entry& a, const Entry& b) {
        return a.weight > b.weight || (a.weight == b.weight && a.rank < b.rank);
    }
    /// Puts `entry` where it belongs at or below the free place `at`.
    void sink(std::size_t at, Entry entry) {
        for (;;) {
            std::size_t child = 2 * at + 1;
            if (child >= heap_.size()) break;
            if (child + 1 < heap_.size() && is_before(heap_[child + 1], heap_[child])) ++child;
            if (!is_before(heap_[child], entry)) break;
            heap_[at] = heap_[child];
            place_[heap_[at].item] = static_cast<std::uint32_t>(at);
            at = child;
        }
        heap_[at] = entry;
        place_[entry.item] = static_cast<std::uint32_t>(at);
    }

    std::vector<Entry> heap_;
    std::vector<std::uint32_t> place_; // of each item in heap_
};

} // namespace

std::vector<SurfacePoint> scatter(std::span<const Vec3d> vertices_world,
                                  std::span<const Eigen::Vector3i> triangles, std::size_t count,
                                  std::uint64_t seed) {
    std::vector<double> area_up_to;
    double area = 0;
    for (const Eigen::Vector3i& t : triangles) {
        const Vec3d& a = vertices_world[static_cast<std::size_t>(t[0])];
        const Vec3d& b = vertices_world[static_cast<std::size_t>(t[1])];
        const Vec3d& c = vertices_world[static_cast<std::size_t>(t[2])];
        area += (b - a).cross(c - a).norm() / 2;
        area_up_to.push_back(area);
    }
    if (count == 0 || !(area > 0)) return {};

    std::mt19937_64 random(seed);
    const std::size_t candidate_count = candidates_per_point * count;
    std::vector<SurfacePoint> points =
        candidates_of(vertices_world, triangles, area_up_to, candidate_count, random);

    // Yuksel's equations for the greatest radius in two dimensions and for the limit of weights.
    const double radius_max =
        std::sqrt(area / (2 * std::numbers::sqrt3 * static_cast<double>(count)));
    const double radius_min =
        radius_max * limit_share * (1 - std::pow(1.0 / candidates_per_point, limit_power));
    const auto weight = [&](double distance) {
        const double d = std::max(distance, 2 * radius_min);
        const double w = 1 - d / (2 * radius_max);
        return (w * w * (w * w)) * (w * w * (w * w)); // alpha = 8
    };
    const Cells cells(points, 2 * radius_max);
    std::vector<double> weights(points.size(), 0);
    tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
        cells.each_near(i, [&](std::size_t, double distance) { weights[i] += weight(distance); });
    });
    // Where nothing is near anything, as on a thin ribbon, all weights are 0: then chance decides,
    // not the order of triangles or cells.
    std::vector<std::uint32_t> ranks(points.size());
    std::iota(ranks.begin(), ranks.end(), std::uint32_t{0});
    for (std::size_t i = ranks.size(); i-- > 1;)
        std::swap(ranks[i], ranks[static_cast<std::size_t>(uniform(random) * double(i + 1))]);
    HeaviestFirst left(weights, ranks);
    while (left.size() > count) {
        const std::size_t gone = left.take();
        cells.each_near(gone, [&](std::size_t j, double distance) {
            if (left.holds(j)) left.lighten(j, weight(distance));
        });
    }
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (left.holds(i)) kept.push_back(cells.original(i));
    std::sort(kept.begin(), kept.end());
    for (std::size_t k = 0; k < kept.size(); ++k) points[k] = points[kept[k]]; // kept[k] >= k
    points.resize(kept.size());
    return points;
}

} // namespace isocast
