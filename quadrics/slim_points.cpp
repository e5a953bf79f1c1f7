// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim_points.h"

#include "quadrics/scrambled.h"
#include "volume/errors.h"

#include <Eigen/Dense>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

namespace isocast {

namespace {

/// Twice as many as a patch has coefficients.
constexpr std::size_t enough_points = 12;
/// Points that face away by more than 120 degrees are of another sheet.
constexpr double other_sheet_cosine = -0.5;
/// Of the spacing, the least radius, with 20 points about; and cells none of which is empty (of
/// points at random one of e^9 is).
constexpr double least_radius_spacings = 2.5;
constexpr double cell_spacings = 3;

/// A kD-tree in an array: each range's middle divides it along its box's longest side.
class BallTree {
public:
    explicit BallTree(std::span<const Vec3d> points) : points_(points), order_(points.size()) {
        std::iota(order_.begin(), order_.end(), 0);
        axes_.resize(points.size());
        build(0, order_.size());
    }
    template<class Visit>
    void visit_ball(const Vec3d& centre, double radius, const Visit& visit) const {
        search(0, order_.size(), centre, radius, visit);
    }

private:
    void build(std::size_t from, std::size_t to) {
        if (to - from < 2) return;
        Eigen::AlignedBox3d box;
        for (std::size_t i = from; i < to; ++i) box.extend(points_[order_[i]]);
        int axis = 0;
        box.sizes().maxCoeff(&axis);
        const std::size_t middle = (from + to) / 2;
        const auto at = [&](std::size_t i) {
            return order_.begin() + static_cast<std::ptrdiff_t>(i);
        };
        std::ranges::nth_element(at(from), at(middle), at(to), {},
                                 [&](std::size_t i) { return std::pair(points_[i][axis], i); });
        axes_[middle] = axis;
        build(from, middle);
        build(middle + 1, to);
    }
    template<class Visit>
    void search(std::size_t from, std::size_t to, const Vec3d& centre, double radius,
                const Visit& visit) const {
        if (from == to) return;
        const std::size_t middle = (from + to) / 2;
        const Vec3d& p = points_[order_[middle]];
        if ((p - centre).squaredNorm() < radius * radius) visit(order_[middle]);
        const double side = centre[axes_[middle]] - p[axes_[middle]];
        if (side < radius) search(from, middle, centre, radius, visit);
        if (side > -radius) search(middle + 1, to, centre, radius, visit);
    }
    std::span<const Vec3d> points_;
    std::vector<std::size_t> order_;
    std::vector<int> axes_; // by place in the order
};

struct PointPiece {
    SlimPatch patch;
    double residual_world = 0;
    std::vector<int> covered; // points
};

class PointCover {
public:
    PointCover(const SlimPoints& points, const BallTree& tree, double diagonal_world,
               double max_error_world)
        : points_(points), tree_(tree), error_(max_error_world),
          greatest_radius_(slim_greatest_radius_share * diagonal_world) {}

    void run(const Progress& progress);
    SlimLevel level(SlimReport& report) const;

private:
    std::optional<PointPiece> fit(std::size_t centre, double radius, bool is_least) const;
    PointPiece grown(std::size_t centre) const;
    bool is_filled(const SlimPatch& patch, const std::vector<std::size_t>& own) const;

    const SlimPoints& points_;
    const BallTree& tree_;
    double error_;
    double greatest_radius_;
    std::vector<bool> is_covered_; // points, by pieces of this round
    std::vector<PointPiece> pieces_;
};

bool PointCover::is_filled(const SlimPatch& patch, const std::vector<std::size_t>& own) const {
    double spacing = 0;
    for (const std::size_t i : own) spacing = std::max(spacing, points_.spacing_world[i]);
    const double cell = cell_spacings * spacing;
    const Mat3d axes = slim_axes(patch.normal);
    const auto cell_of = [&](double u) { return static_cast<int>(std::lround(u / cell)); };
    std::set<std::array<int, 2>> filled;
    for (const std::size_t i : own) {
        const Vec3d q = axes.transpose() * (points_.points_world[i] - patch.centre_world);
        filled.insert({cell_of(q.x()), cell_of(q.y())});
    }
    const auto is_inside = [&](double u, double v) { // the sphere, the place on the graph
        const double w = height_at(patch, u, v);
        return u * u + v * v + w * w < patch.radius_world * patch.radius_world;
    };
    const int most = cell_of(patch.radius_world);
    for (int j = -most; j <= most; ++j)
        for (int i = -most; i <= most; ++i) {
            const double u = i - 0.5;
            const double v = j - 0.5;
            if (!filled.contains({i, j}) && is_inside(u * cell, v * cell) &&
                is_inside((u + 1) * cell, v * cell) && is_inside(u * cell, (v + 1) * cell) &&
                is_inside((u + 1) * cell, (v + 1) * cell))
                return false;
        }
    return true;
}

/// is_least  holds, whatever it is off by
std::optional<PointPiece> PointCover::fit(std::size_t centre, double radius, bool is_least) const {
    PointPiece piece;
    SlimPatch& patch = piece.patch;
    patch.centre_world = points_.points_world[centre];
    patch.radius_world = radius;
    Vec3d normal = Vec3d::Zero();
    std::vector<std::size_t> own;
    bool turns = false;
    const Vec3d& facing = points_.normals[centre];
    tree_.visit_ball(patch.centre_world, radius, [&](std::size_t i) {
        const double cosine = facing.dot(points_.normals[i]);
        turns = turns || (cosine < slim_least_cosine && cosine > other_sheet_cosine);
        if (cosine < slim_least_cosine) return;
        own.push_back(i);
        normal += points_.spacing_world[i] * points_.spacing_world[i] * points_.normals[i];
    });
    if (!is_least && (turns || own.size() < enough_points)) return std::nullopt;
    patch.normal = normal.normalized();
    const Mat3d axes = slim_axes(patch.normal);
    const auto local = [&](std::size_t i) {
        return Vec3d(axes.transpose() * (points_.points_world[i] - patch.centre_world) / radius);
    };
    HeightFit fit;
    for (const std::size_t i : own) {
        const double spacing = points_.spacing_world[i] / radius;
        fit.add(local(i), spacing * spacing);
    }
    HeightFit::Vector6 h = HeightFit::Vector6::Zero();
    if (own.size() >= enough_points) h = fit.solved();
    const auto residual = [&] {
        double greatest = 0;
        for (const std::size_t i : own) {
            const Vec3d q = local(i);
            greatest = std::max(greatest, radius * std::abs(q.z() - h.dot(HeightFit::basis_of(q))));
        }
        return greatest;
    };
    const double spare = spare_of(radius, error_);
    piece.residual_world = residual();
    if (!(piece.residual_world <= spare)) {
        if (!is_least) return std::nullopt;
        const HeightFit::Vector6 bent = std::exchange(h, HeightFit::Vector6::Zero());
        const double flat = residual();
        if (piece.residual_world < flat)
            h = bent;
        else
            piece.residual_world = flat;
    }
    patch.height = HeightFit::height_of(h, radius);
    patch.errors = std::max(1.0, piece.residual_world / error_);
    if (!is_least && !is_filled(patch, own)) return std::nullopt;
    const double reach = std::min(slim_covered_share * radius, radius - spare);
    for (const std::size_t i : own)
        if ((points_.points_world[i] - patch.centre_world).norm() + points_.spacing_world[i] <=
                reach ||
            i == centre)
            piece.covered.push_back(static_cast<int>(i));
    return piece;
}

PointPiece PointCover::grown(std::size_t centre) const {
    const double least = least_radius_spacings * points_.spacing_world[centre];
    const double greatest = std::max(greatest_radius_, least);
    std::optional<PointPiece> best;
    double good = least; // which holds, whatever it is off by
    double bad = 0;
    double radius = std::min(2 * least, greatest);
    while (good < greatest && (bad == 0 || bad > good * slim_radius_precision)) {
        auto piece = fit(centre, radius, false);
        if (piece) {
            best = std::move(piece);
            good = radius;
        } else {
            bad = radius;
        }
        radius = bad == 0 ? std::min(2 * good, greatest) : std::sqrt(good * bad);
    }
    return best ? std::move(*best) : *fit(centre, least, true);
}

void PointCover::run(const Progress& progress) {
    const std::size_t count = points_.points_world.size();
    std::vector<std::uint64_t> keys(count);
    std::iota(keys.begin(), keys.end(), 0);
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    for (int round = 0; round < slim_rounds; ++round) {
        for (std::uint64_t& key : keys) key = scrambled(key);
        std::ranges::sort(order, {}, [&](std::size_t i) { return keys[i]; });
        is_covered_.assign(count, false);
        const std::size_t first = pieces_.size();
        for (std::size_t at = 0; at < count;) {
            // Some at a time, as of meshes: the same for any threads.
            const std::size_t most = std::max<std::size_t>(32, (pieces_.size() - first) / 8);
            std::vector<std::size_t> batch;
            for (; at < count && batch.size() < most; ++at)
                if (!is_covered_[order[at]]) batch.push_back(order[at]);
            std::vector<PointPiece> made(batch.size());
            tbb::parallel_for(std::size_t{0}, batch.size(),
                              [&](std::size_t i) { made[i] = grown(batch[i]); });
            for (PointPiece& piece : made) {
                for (const int p : piece.covered) is_covered_[static_cast<std::size_t>(p)] = true;
                pieces_.push_back(std::move(piece));
            }
            if (progress)
                progress("covering",
                         (round + static_cast<double>(at) / static_cast<double>(count)) /
                             slim_rounds);
        }
    }
}

SlimLevel PointCover::level(SlimReport& report) const {
    std::vector<std::vector<int>> covering(points_.points_world.size());
    for (std::size_t i = 0; i < pieces_.size(); ++i)
        for (const int p : pieces_[i].covered)
            covering[static_cast<std::size_t>(p)].push_back(static_cast<int>(i));
    const std::vector<bool> stays = needed_patches(covering, pieces_.size());
    SlimLevel out{.patches = {}, .max_error_world = error_};
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
        if (!stays[p]) continue;
        out.patches.push_back(pieces_[p].patch);
        report.over_bound += pieces_[p].residual_world > error_ ? 1 : 0;
        report.greatest_error_world =
            std::max(report.greatest_error_world, pieces_[p].residual_world);
    }
    return out;
}

} // namespace

SlimSurface slim_of_points(const SlimPoints& points, double max_error_world,
                           std::vector<SlimReport>& reports, const Progress& progress) {
    const std::size_t count = points.points_world.size();
    if (count < enough_points)
        throw InputError(fmt::format("{} points are too few for a SLIM surface, which takes {}",
                                     count, enough_points));
    Eigen::AlignedBox3d box;
    for (const Vec3d& p : points.points_world) box.extend(p);
    const double diagonal = box.diagonal().norm();
    const BallTree tree(points.points_world);
    return with_levels(max_error_world, 16, diagonal, reports,
                       [&](double error, SlimReport& report) {
                           PointCover cover(points, tree, diagonal, error);
                           cover.run(progress);
                           return cover.level(report);
                       });
}

} // namespace isocast
