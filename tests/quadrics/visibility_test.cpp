// What is left out is hidden: against the nearest sphere on the ray through each pixel.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/visibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>

namespace isocast {
namespace {

struct Ball {
    Vec3d centre_eye;
    double radius;
};

/// The ray through the middle of pixel (i, j): a point, and what is added at depth one.
struct EyeRay {
    Vec3d origin;
    Vec3d direction;
};
EyeRay eye_ray(const FootprintView& view, int i, int j) {
    const Vec3d at((i + 0.5 - view.middle_pixels.x()) / view.pixels_per_unit,
                   (j + 0.5 - view.middle_pixels.y()) / view.pixels_per_unit, 0);
    return view.is_perspective ? EyeRay{Vec3d::Zero(), at - Vec3d::UnitZ()}
                               : EyeRay{at, -Vec3d::UnitZ()};
}

/// The depth at which a ray enters a ball, or, before the near plane, leaves it.
double depth_of(const FootprintView& view, const EyeRay& ray, const Ball& ball) {
    const Vec3d o = ball.centre_eye - ray.origin;
    const double a = ray.direction.squaredNorm();
    const double t0 = ray.direction.dot(o) / a;
    const double h = ball.radius * ball.radius - (ray.direction * t0 - o).squaredNorm();
    if (h < 0) return INFINITY;
    const double s = std::sqrt(h / a);
    if (!view.is_perspective || t0 - s >= view.near_depth) return t0 - s;
    return t0 + s >= view.near_depth ? t0 + s : INFINITY;
}

std::vector<Footprint> footprints_of(const FootprintView& view, const std::vector<Ball>& balls) {
    std::vector<Footprint> footprints;
    for (const Ball& ball : balls)
        footprints.push_back(sphere_footprint(view, ball.centre_eye, ball.radius));
    return footprints;
}

/// The ball that each pixel sees, at every `step`th pixel both ways; each is expected to be in
/// `visible`, its pixel in its box, and its disc's pixels on it and no farther than said.
void expect_all_seen(const FootprintView& view, const std::vector<Ball>& balls, int step,
                     int& hits) {
    const std::vector<Footprint> footprints = footprints_of(view, balls);
    const std::vector<VisibleFootprint> list =
        visible_footprints(footprints, view.width, view.height);
    std::map<std::size_t, VisibleFootprint> visible;
    for (const VisibleFootprint& seen : list) visible[seen.number] = seen;
    EXPECT_EQ(visible.size(), list.size());
    // From front to back, but for 2^-12 of the depths there are.
    float farthest = 0;
    for (const Footprint& f : footprints) farthest = std::max(farthest, f.nearest_depth);
    for (std::size_t k = 1; k < list.size(); ++k)
        EXPECT_LE(footprints[list[k - 1].number].nearest_depth,
                  footprints[list[k].number].nearest_depth + farthest * 0x1p-12F);
    for (int j = 0; j < view.height; j += step)
        for (int i = 0; i < view.width; i += step) {
            const EyeRay ray = eye_ray(view, i, j);
            double nearest = INFINITY;
            std::size_t winner = 0;
            for (std::size_t k = 0; k < balls.size(); ++k) {
                const double depth = depth_of(view, ray, balls[k]);
                const Footprint& f = footprints[k];
                if (std::hypot(i + 0.5 - f.disc_x, j + 0.5 - f.disc_y) < f.disc_radius - 1e-3) {
                    ASSERT_LE(depth, f.disc_depth + 1e-6 * std::abs(f.disc_depth));
                }
                if (depth < nearest) {
                    nearest = depth;
                    winner = k;
                }
            }
            if (nearest == INFINITY) continue;
            ++hits;
            const Footprint& f = footprints[winner];
            const auto seen = visible.find(winner);
            ASSERT_NE(seen, visible.end()) << "at " << i << ", " << j;
            const VisibleFootprint& box = seen->second;
            ASSERT_TRUE(i >= box.x_lo && i < box.x_hi && j >= box.y_lo && j < box.y_hi)
                << "at " << i << ", " << j;
            ASSERT_GE(nearest, f.nearest_depth - 1e-6 * std::abs(f.nearest_depth));
            ASSERT_TRUE(i + 0.5 >= f.x_lo - 1e-2 && i + 0.5 <= f.x_hi + 1e-2 &&
                        j + 0.5 >= f.y_lo - 1e-2 && j + 0.5 <= f.y_hi + 1e-2);
        }
}

using Random = std::mt19937_64;
double real(Random& random, double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random);
}
Vec3d in_ball(Random& random) {
    for (;;) {
        const Vec3d p(real(random, -1, 1), real(random, -1, 1), real(random, -1, 1));
        if (p.norm() <= 1) return p;
    }
}

TEST(Visibility, NoSphereThatIsSeenIsLeftOut) {
    Random random(1);
    int hits = 0;
    for (int run = 0; run < 40; ++run) {
        FootprintView view{
            .is_perspective = run % 3 != 0,
            .width = 90 + 13 * (run % 7),
            .height = 50 + 11 * (run % 5),
            .middle_pixels = {0.5 * (90 + 13 * (run % 7)), 0.5 * (50 + 11 * (run % 5))},
            .near_depth = 0.05};
        view.pixels_per_unit = view.is_perspective ? real(random, 40, 200) : real(random, 5, 30);
        std::vector<Ball> balls;
        const int count = 1 << run % 10;
        const double size = real(random, 0.05, 1);
        for (int i = 0; i < count; ++i)
            balls.push_back({3 * in_ball(random) - Vec3d(0, 0, real(random, 2, 8)),
                             size * real(random, 0.1, 1)});
        expect_all_seen(view, balls, 1, hits);
    }
    EXPECT_GT(hits, 100000);
}

TEST(Visibility, WithTheEyeInACrowdAndInASphere) {
    Random random(2);
    const FootprintView view{.width = 160,
                             .height = 120,
                             .middle_pixels = {80, 60},
                             .pixels_per_unit = 60,
                             .near_depth = 0.01};
    std::vector<Ball> balls{{{0.1, 0, 0}, 0.5}, {{0, 0, -30}, 29.995}};
    for (int i = 0; i < 500; ++i) balls.push_back({4 * in_ball(random), real(random, 0.01, 0.5)});
    int hits = 0;
    expect_all_seen(view, balls, 1, hits);
    EXPECT_EQ(hits, view.width * view.height);
}

TEST(Visibility, OfEqualSpheresAtOnePlaceOneIsLeft) {
    const FootprintView view{.width = 64,
                             .height = 64,
                             .middle_pixels = {32, 32},
                             .pixels_per_unit = 40,
                             .near_depth = 0.01};
    const std::vector<Ball> balls(1000, Ball{{0, 0, -3}, 1});
    const auto footprints = footprints_of(view, balls);
    EXPECT_GE(visible_footprints(footprints, 64, 64).size(), 1U);
    // Behind it there is nothing to see, beside it there is.
    std::vector<Ball> more{{{0, 0, -3}, 1}, {{0, 0, -6}, 1}, {{1.5, 0, -3.5}, 0.4}};
    const auto seen = visible_footprints(footprints_of(view, more), 64, 64);
    ASSERT_EQ(seen.size(), 2U);
    EXPECT_EQ(seen[0].number, 0U);
    EXPECT_EQ(seen[1].number, 2U);
}

TEST(Visibility, EmptyPicturesAndListsAreEmpty) {
    EXPECT_TRUE(visible_footprints({}, 100, 100).empty());
    const FootprintView view{
        .width = 8, .height = 8, .middle_pixels = {4, 4}, .pixels_per_unit = 8, .near_depth = 0.01};
    const std::vector<Ball> beside{{{50, 0, -3}, 1}, {{0, -50, -3}, 1}};
    EXPECT_TRUE(visible_footprints(footprints_of(view, beside), 8, 8).empty());
}

TEST(Visibility, FewOfManySpheresInABallAreLeft) {
    // As in table 7.2's largest scenes: 52,000 spheres in a ball, 45 over each pixel.
    Random random(3);
    const FootprintView view{.width = 1024,
                             .height = 768,
                             .middle_pixels = {512, 384},
                             .pixels_per_unit = 1433,
                             .near_depth = 0.01};
    std::vector<Ball> balls;
    for (int i = 0; i < 52000; ++i)
        balls.push_back({in_ball(random) - Vec3d(0, 0, 4.2), real(random, 0.02, 0.03)});
    const auto footprints = footprints_of(view, balls);
    const auto visible = visible_footprints(footprints, view.width, view.height);
    const double share = double(visible.size()) / double(balls.size());
    RecordProperty("share", std::to_string(share));
    EXPECT_LT(share, 0.2);
    int hits = 0;
    expect_all_seen(view, balls, 31, hits);
    EXPECT_GT(hits, 200);
}

} // namespace
} // namespace isocast
