// Ellipsoids of curvature: lengths by Dupin's indicatrix, seated, and the same however one turns.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/tensor_glyphs.h"

#include "filtering/curvature.h"
#include "quadrics/quadric.h"
#include "random_primitives.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace isocast {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double infinity = std::numeric_limits<double>::infinity();

Vec3d lengths_of(const Ellipsoid& e) {
    return e.axes_world.colwise().norm();
}

CurvedPoint random_point(Random& random) {
    CurvedPoint p{.position_world = random.in_cube(3), .normal = random.unit()};
    p.k1 = random.log_uniform(1e-3, 1e3) * (random.coin() ? 1 : -1);
    p.k2 = random.log_uniform(1e-3, 1e3) * (random.coin() ? 1 : -1);
    p.direction1 = p.normal.cross(random.unit()).normalized();
    return p;
}

// On an ellipsoid, whose curvatures are another module's: the surface has fallen by one depth,
// size^2 curvature_of_size / 2, under each end of each glyph.
TEST(CurvatureGlyphs, EndsLieAtOneDepthOfTheOsculatingParaboloid) {
    const Ellipsoid body{.axes_world = Vec3d(1, 2, 3).asDiagonal()};
    Random random(1);
    std::vector<CurvedPoint> points;
    std::vector<Curvatures> curvatures;
    for (int i = 0; i < 500; ++i) {
        const Vec3d p = body.axes_world * random.unit();
        const QuadricDerivatives d = derivatives(body, p);
        const Curvatures c = principal_curvatures(d.gradient, d.hessian);
        points.push_back({p, d.gradient.normalized(), c.k1, c.k2, c.direction1});
        curvatures.push_back(c);
    }
    // 1/9 to 3: all curvatures of the body, so that nothing is clamped.
    const CurvatureGlyphLook look{
        .size_world = 0.1, .curvature_of_size = 1.0 / 9, .least_share = 0.1};
    const std::vector<Ellipsoid> glyphs = curvature_ellipsoids(points, look);
    ASSERT_EQ(glyphs.size(), points.size());
    for (std::size_t i = 0; i < glyphs.size(); ++i) {
        const Vec3d a = lengths_of(glyphs[i]);
        const double depth = 0.01 / 9 / 2;
        // Roundings of a root and squares.
        EXPECT_NEAR(curvatures[i].k1 * a[0] * a[0] / 2, depth, 16 * eps * depth);
        EXPECT_NEAR(curvatures[i].k2 * a[1] * a[1] / 2, depth, 16 * eps * depth);
        EXPECT_NEAR(
            std::abs(glyphs[i].axes_world.col(0).normalized().dot(curvatures[i].direction1)), 1,
            1e-12);                                                  // derivatives() states 1e-12
        EXPECT_EQ(glyphs[i].centre_world, points[i].position_world); // convex: not lifted
    }
    check(std::span<const Ellipsoid>(glyphs));
}

TEST(CurvatureGlyphs, AreFlatAlongTheNormalAndWithinTheirSizes) {
    Random random(2);
    std::vector<CurvedPoint> points;
    for (int i = 0; i < 1000; ++i) points.push_back(random_point(random));
    const CurvatureGlyphLook look{.size_world = 0.7};
    const std::vector<Ellipsoid> glyphs = curvature_ellipsoids(points, look);
    for (std::size_t i = 0; i < glyphs.size(); ++i) {
        const Vec3d a = lengths_of(glyphs[i]);
        const double slack = 4 * eps; // of a unit vector's length
        EXPECT_GE(a.head<2>().minCoeff(), 0.2 * 0.7 * (1 - slack));
        EXPECT_LE(a.head<2>().maxCoeff(), 0.7 * (1 + slack));
        EXPECT_NEAR(a[2], 0.25 * a.head<2>().minCoeff(), slack);
        EXPECT_NEAR(glyphs[i].axes_world.col(2).normalized().dot(points[i].normal), 1, slack);
        EXPECT_GT(glyphs[i].axes_world.determinant(), 0);
        EXPECT_GE(glyphs[i].colour.minCoeff(), 0);
        EXPECT_LE(glyphs[i].colour.maxCoeff(), 1);
        // The axis of the greater |k| is the shorter one, or both are clamped.
        const bool is_first = std::abs(points[i].k1) > std::abs(points[i].k2);
        EXPECT_LE(a[is_first ? 0 : 1], a[is_first ? 1 : 0] * (1 + slack));
    }
    check(std::span<const Ellipsoid>(glyphs));
}

TEST(CurvatureGlyphs, TurnAndGrowWithTheSurface) {
    Random random(3);
    for (int k = 0; k < 300; ++k) {
        CurvedPoint p = random_point(random);
        if (k % 10 == 0) p.k2 = p.k1; // an umbilic, with another direction after the turn
        if (k % 10 == 1) p.k1 = 0;
        const Mat3d turn = random.rotation();
        const double scale = random.log_uniform(1e-3, 1e3);
        CurvedPoint q{turn * p.position_world * scale, turn * p.normal, p.k1 / scale, p.k2 / scale,
                      turn * p.direction1 * (random.coin() ? 1 : -1)};
        if (p.k1 == p.k2) q.direction1 = q.normal.cross(random.unit());
        const Ellipsoid before =
            curvature_ellipsoids({&p, 1}, {.size_world = 1, .curvature_of_size = 0.5})[0];
        const Ellipsoid after = curvature_ellipsoids(
            {&q, 1}, {.size_world = scale, .curvature_of_size = 0.5 / scale})[0];
        // The ellipsoid as a set: axes axes^T.
        const Mat3d expected =
            turn * before.axes_world * before.axes_world.transpose() * turn.transpose();
        const Mat3d found = after.axes_world * after.axes_world.transpose() / (scale * scale);
        EXPECT_LE((found - expected).norm(), 64 * eps); // roundings of a dozen products of 1
        EXPECT_LE((after.centre_world / scale - turn * before.centre_world).norm(), 64 * eps);
    }
}

TEST(CurvatureGlyphs, UmbilicsAreDiscsAndGreyWithAnyDirection) {
    Random random(4);
    for (const double k : {2.0, -2.0, 0.0})
        for (const Vec3d& direction :
             {Vec3d(Vec3d::Zero()), Vec3d(0, 0, 1), random.unit(), Vec3d(Vec3d::UnitX())}) {
            const CurvedPoint p{.k1 = k, .k2 = k, .direction1 = direction};
            const Ellipsoid e = curvature_ellipsoids({&p, 1}, {.curvature_of_size = 1})[0];
            const Vec3d a = lengths_of(e);
            EXPECT_NEAR(a[0], k == 0 ? 1 : std::sqrt(0.5), 4 * eps);
            EXPECT_NEAR(a[1], a[0], 4 * eps);
            EXPECT_EQ(e.colour, Vec3d::Constant(0.5).eval());
        }
}

TEST(CurvatureGlyphs, OfCylindersLieAlongTheirAxisInTheColourOfTheWayAround) {
    const CurvedPoint p{.normal = Vec3d::UnitX(), .k1 = 4, .direction1 = Vec3d::UnitY()};
    const Ellipsoid e = curvature_ellipsoids({&p, 1}, {.curvature_of_size = 1})[0];
    EXPECT_EQ(lengths_of(e), Vec3d(0.5, 1, 0.125));
    EXPECT_EQ(e.axes_world.col(1).cwiseAbs(), Vec3d(Vec3d::UnitZ()));
    EXPECT_EQ(e.colour, Vec3d(0, 1, 0));
}

// A bowl of radius 2, a saddle, a groove: no end of a glyph lies below the surface there.
TEST(CurvatureGlyphs, AreLiftedOutOfHollows) {
    for (const auto& [k1, k2] : {std::pair(-0.5, -0.5), std::pair(0.5, -0.25), std::pair(0.0, -3.0),
                                 std::pair(-100.0, -100.0), std::pair(0.5, 0.5)}) {
        const CurvedPoint p{.k1 = k1, .k2 = k2};
        const Ellipsoid e = curvature_ellipsoids({&p, 1}, {.curvature_of_size = 1})[0];
        const double lift = e.centre_world.z();
        const Vec3d a = lengths_of(e);
        for (const auto& [k, length] : {std::pair(k1, a[0]), std::pair(k2, a[1])})
            if (-k * length <= 1) { // not beyond the middle of the osculating circle
                // The circle's rise is that of the parabola and up to twice at its middle.
                EXPECT_GE(lift * (1 + eps), -k * length * length / 2);
            }
        EXPECT_LE(lift, 1);
        if (k1 >= 0 && k2 >= 0) {
            EXPECT_EQ(lift, 0);
        }
    }
}

TEST(CurvatureGlyphs, AreFiniteForFlatPointsAndApices) {
    const std::vector<CurvedPoint> points = {
        {},
        {.k1 = infinity, .k2 = 0},
        {.k1 = infinity, .k2 = -infinity},
        {.k1 = -infinity, .k2 = -infinity},
        {.k1 = 1e300, .k2 = -1e-300},
        {.k1 = std::numeric_limits<double>::denorm_min(), .k2 = 0}};
    for (const double full : {1e-300, 1.0, 1e300})
        for (const Ellipsoid& e :
             curvature_ellipsoids(points, {.size_world = 2, .curvature_of_size = full})) {
            EXPECT_TRUE(e.centre_world.allFinite());
            EXPECT_TRUE(e.axes_world.allFinite());
            EXPECT_TRUE(e.colour.allFinite());
            check({&e, 1});
        }
}

TEST(CurvatureGlyphs, TypicalCurvatureIsTheLowerQuartile) {
    std::vector<CurvedPoint> points;
    for (int i = 1; i <= 50; ++i)
        points.push_back({.k1 = double(2 * i), .k2 = -double(2 * i - 1)}); // 1 to 100
    points.push_back({});                                                  // counts for nothing
    EXPECT_EQ(typical_curvature(points), 26);
    EXPECT_EQ(typical_curvature({}), 1);
    const auto glyphs = curvature_ellipsoids(points);
    int full = 0;
    for (const Ellipsoid& e : std::span(glyphs).first(50)) {
        const Vec3d a = lengths_of(e);
        full += (a[0] > 1 - 4 * eps) + (a[1] > 1 - 4 * eps);
    }
    EXPECT_EQ(full, 26);
}

} // namespace
} // namespace isocast
