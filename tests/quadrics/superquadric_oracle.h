// Superquadrics by their definition, and rays that meet them by brute force.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../volume/temporary_folder.h" // message_of
#include "filtering/curvature.h"
#include "quadric_oracle.h"
#include "quadrics/superquadric.h"
#include "random_primitives.h"
#include "volume/errors.h"
#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

namespace isocast {

using oracle::Q3;
using oracle::Quad;
using ::testing::HasSubstr;
inline constexpr double eps = std::numeric_limits<double>::epsilon();

// ------------------------------------------------------------------------- the definition, plainly

/// N by the powers of the definition, which neither over- nor underflow in long double.
inline long double norm_of(long double x, long double y, long double z, double p, double r) {
    const long double m_r =
        std::pow(std::pow(std::abs(x), (long double)p) + std::pow(std::abs(y), (long double)p),
                 (long double)r / p);
    return std::pow(m_r + std::pow(std::abs(z), (long double)r), 1 / (long double)r);
}
inline long double norm_at(const Superquadric& s, const Q3& p) {
    const Q3 q = oracle::solve(s.axes_world, p - oracle::of(s.centre_world));
    return norm_of((long double)q.x, (long double)q.y, (long double)q.z, 2 / s.alpha, 2 / s.beta);
}

struct BruteForce {
    long double least = 0; // N along the ray
    Quad t_least = 0;
    std::optional<Quad> first, last; // where N = 1
};

inline BruteForce brute_force(const Superquadric& s, const Vec3d& origin, const Vec3d& direction) {
    const auto at = [&](Quad t) { return oracle::of(origin) + oracle::of(direction) * t; };
    const auto n = [&](Quad t) { return norm_at(s, at(t)); };
    // Samples over a ball that holds the body, twice.
    const double middle = direction.dot(s.centre_world - origin) / direction.squaredNorm();
    const double half = 4 * s.axes_world.norm() / direction.norm();
    constexpr int samples = 100;
    int best = 0;
    std::vector<long double> values;
    for (int i = 0; i <= samples; ++i) {
        values.push_back(n(middle + half * (2.0 * i / samples - 1)));
        if (values[std::size_t(i)] < values[std::size_t(best)]) best = i;
    }
    Quad from = middle + half * (2.0 * (best - 1) / samples - 1);
    Quad to = middle + half * (2.0 * (best + 1) / samples - 1);
    for (int i = 0; i < 110; ++i) { // (2/3)^110: 4e-20
        const Quad a = from + (to - from) / 3, b = to - (to - from) / 3;
        if (n(a) <= n(b))
            to = b;
        else
            from = a;
    }
    BruteForce found{
        .least = n((from + to) / 2), .t_least = (from + to) / 2, .first = {}, .last = {}};
    if (found.least >= 1) return found;
    const auto root = [&](Quad outside) {
        Quad inside = found.t_least;
        for (int i = 0; i < 90; ++i) {
            const Quad t = (outside + inside) / 2;
            (n(t) < 1 ? inside : outside) = t;
        }
        return outside;
    };
    found.first = root(middle - half);
    found.last = root(middle + half);
    return found;
}

inline Superquadric random_superquadric(Random& random) {
    Superquadric s;
    s.centre_world = random.in_cube(1);
    s.axes_world = random.rotation() * Vec3d(random.log_uniform(0.1, 1), random.log_uniform(0.1, 1),
                                             random.log_uniform(0.1, 1))
                                           .asDiagonal();
    s.alpha = random.coin() ? random.log_uniform(0.05, 1) : 1;
    s.beta = random.coin() ? random.log_uniform(0.05, 1) : random.coin() ? 0.05 : s.alpha;
    return s;
}

/// In terms of N: 32 roundings, as ray_superquadric.h states, and 4 of the distance.
inline double tolerance(const Superquadric& s, const Vec3d& origin, double epsilon) {
    const double distance = (s.centre_world - origin).norm();
    return epsilon * (32 + 4 * distance * s.axes_world.inverse().norm());
}

/// returns  whether there was something to compare, not a ray within rounding of a miss
template<class Real>
inline bool expect_first_hit(const Superquadric& s, const Vec3d& origin, const Vec3d& direction,
                             const char* what) {
    const double allowed = tolerance(s, origin, std::numeric_limits<Real>::epsilon());
    const BruteForce expected = brute_force(s, origin, direction);
    const auto hit = first_hit(seen_from<Real>(s, origin),
                               Eigen::Vector3<Real>(direction.cast<Real>()), Real(0));
    const bool is_behind = expected.last && *expected.last < 0;
    const std::string shape = fmt::format("{}: alpha {}, beta {}, least N - 1 {}", what, s.alpha,
                                          s.beta, double(expected.least - 1));
    if (std::abs(double(expected.least - 1)) <= allowed) return false;
    if (expected.least > 1 || is_behind) {
        EXPECT_FALSE(hit) << shape;
        return true;
    }
    EXPECT_TRUE(hit) << shape;
    if (!hit) return true;
    const bool is_inside = *expected.first < 0;
    EXPECT_EQ(hit->is_inside, is_inside) << shape;
    // Direction and t are rounded to Real: N is taken where the Real's ray is.
    const Vec3d rounded = direction.cast<Real>().template cast<double>();
    const Q3 p = oracle::of(origin) + oracle::of(rounded) * Quad(hit->t);
    EXPECT_LE(std::abs(double(norm_at(s, p) - 1)), allowed) << shape;
    // N is within the tolerance on both sides of the body: this is the right one.
    const double root = double(is_inside ? *expected.last : *expected.first);
    const double other = double(is_inside ? *expected.first : *expected.last);
    EXPECT_LE(std::abs(double(hit->t) - root), std::abs(double(hit->t) - other)) << shape;
    return true;
}

} // namespace isocast
