// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim_choice.h"

#include "volume/stopwatch.h"

#include <Eigen/Dense>

#include <algorithm>
#include <numeric>
#include <queue>
#include <utility>

namespace isocast {

namespace {

/// Errors of levels, each by the one before: a pixel that is twice as large means twice as much,
/// and in between two levels are blended.
constexpr double level_factor = 4;
/// What is drawn in no time needs no coarser level.
constexpr std::size_t few_patches = 200;
/// Of the patches of the level before: more are not worth their memory.
constexpr double greatest_level_share = 2.0 / 3;

/// Of a coarser level's patches: more that are off by more than its error, and it shows.
constexpr double greatest_share_over_bound = 0.02;

bool is_worth_it(const SlimLevel& level, const SlimLevel& finer, const SlimReport& report) {
    const auto count = static_cast<double>(level.patches.size());
    return count < greatest_level_share * static_cast<double>(finer.patches.size()) &&
           static_cast<double>(report.over_bound) <= greatest_share_over_bound * count;
}

} // namespace

HeightFit::Vector6 HeightFit::basis_of(const Vec3d& q) {
    Vector6 basis;
    basis << 1, q.x(), q.y(), q.x() * q.x(), q.x() * q.y(), q.y() * q.y();
    return basis;
}

void HeightFit::add(const Vec3d& q, double weight) {
    const Vector6 basis = basis_of(q);
    for (Eigen::Index j = 0; j < 6; ++j) // the lower half, which is all that is solved
        sum_.col(j).tail(6 - j) += weight * basis[j] * basis.tail(6 - j);
    right_ += weight * q.z() * basis;
}

HeightFit::Vector6 HeightFit::solved() const {
    // 1e-12: what lies on a line or in a strip leaves some bends open, which then become 0.
    return (sum_ + 1e-12 * sum_.trace() * Matrix6::Identity()).ldlt().solve(right_);
}

std::array<double, 6> HeightFit::height_of(const Vector6& h, double radius_world) {
    const double r = radius_world;
    return {h[0] * r, h[1], h[2], h[3] / r, h[4] / r, h[5] / r};
}

std::vector<bool> needed_patches(const std::vector<std::vector<int>>& covering, std::size_t count) {
    std::vector<std::vector<std::size_t>> things_of(count);
    for (std::size_t i = 0; i < covering.size(); ++i)
        for (const int p : covering[i]) things_of[static_cast<std::size_t>(p)].push_back(i);
    std::vector<int> held(covering.size(), 0); // by how many of those that are taken
    std::vector<bool> stays(count, false);
    // What a patch adds only falls: the first whose number is still true adds most.
    std::priority_queue<std::pair<std::size_t, std::size_t>> by_gain;
    for (std::size_t p = 0; p < count; ++p) by_gain.emplace(things_of[p].size(), p);
    while (!by_gain.empty()) {
        const auto [promised, p] = by_gain.top();
        by_gain.pop();
        const auto gain = static_cast<std::size_t>(
            std::ranges::count_if(things_of[p], [&](std::size_t i) { return held[i] == 0; }));
        if (gain == 0) continue;
        if (gain < promised) {
            by_gain.emplace(gain, p);
            continue;
        }
        stays[p] = true;
        for (const std::size_t i : things_of[p]) ++held[i];
    }
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](std::size_t p) { return things_of[p].size(); });
    for (const std::size_t p : order) {
        if (!stays[p] ||
            std::ranges::any_of(things_of[p], [&](std::size_t i) { return held[i] == 1; }))
            continue;
        stays[p] = false;
        for (const std::size_t i : things_of[p]) --held[i];
    }
    return stays;
}

SlimSurface
with_levels(double max_error_world, int max_levels, double diagonal_world,
            std::vector<SlimReport>& reports,
            const std::function<SlimLevel(double max_error_world, SlimReport& report)>& cover) {
    SlimSurface out;
    reports.clear();
    const double greatest_error =
        slim_greatest_radius_share / slim_fall_back_errors * diagonal_world;
    double error = max_error_world;
    do {
        const Stopwatch time;
        SlimReport report;
        SlimLevel level = cover(error, report);
        report.seconds = time.seconds();
        if (!out.levels.empty() && !is_worth_it(level, out.levels.back(), report)) break;
        out.levels.push_back(std::move(level));
        reports.push_back(report);
        error *= level_factor;
    } while (std::ssize(out.levels) < max_levels && error <= greatest_error &&
             out.levels.back().patches.size() >= few_patches);
    return out;
}

} // namespace isocast
