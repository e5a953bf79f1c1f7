// Curvatures of surfaces where they are known, and of matrices that are hard.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/curvature.h"

#include "../volume/random_fields.h"
#include "filtering/filter.h"
#include "filtering/reconstruct.h"
#include "volume/analytic_fields.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace isocast {
namespace {

using test::Random;

// A few roundings of the greatest curvature; exact input.
constexpr double tolerance = 1e-13;

void expect_orthonormal(const Curvatures& c, const Vec3d& gradient) {
    const Vec3d n = gradient.normalized();
    EXPECT_NEAR(c.direction1.norm(), 1, tolerance);
    EXPECT_NEAR(c.direction2.norm(), 1, tolerance);
    EXPECT_NEAR(c.direction1.dot(c.direction2), 0, tolerance);
    EXPECT_NEAR(c.direction1.dot(n), 0, tolerance);
    EXPECT_NEAR(c.direction2.dot(n), 0, tolerance);
}

TEST(Curvature, OfASphereIsTheInverseOfItsRadiusTwice) {
    Random random(1);
    const AnalyticField sphere = sphere_field(Vec3d(1, 2, 3), 1);
    for (int i = 0; i < 1000; ++i) {
        const double r = std::exp2(test::random_real(random, -20, 20));
        const Vec3d p = Vec3d(1, 2, 3) + r * test::random_point(random, -1, 1).normalized();
        const Jet jet = sphere.jet(p);
        const double radius = (p - Vec3d(1, 2, 3)).norm();
        const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
        EXPECT_NEAR(c.k1 * radius, 1, tolerance);
        EXPECT_NEAR(c.k2 * radius, 1, tolerance);
        expect_orthonormal(c, jet.gradient);
    }
}

TEST(Curvature, OfATorusFollowsItsCircles) {
    Random random(2);
    constexpr double major = 1;
    constexpr double minor = 0.4;
    const AnalyticField torus = torus_field(Vec3d::Zero(), Vec3d::UnitZ(), major, minor);
    for (int i = 0; i < 1000; ++i) {
        const double u = test::random_real(random, -3.1, 3.1);
        const double v = test::random_real(random, -3.1, 3.1);
        const double ring = major + minor * std::cos(v);
        const Vec3d p(ring * std::cos(u), ring * std::sin(u), minor * std::sin(v));
        const Jet jet = torus.jet(p);
        const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
        EXPECT_NEAR(c.k1, 1 / minor, 1e-12); // the field's own roundings: 1/minor^2 of them
        EXPECT_NEAR(c.k2, std::cos(v) / ring, 1e-12);
        const Vec3d meridian(-std::sin(v) * std::cos(u), -std::sin(v) * std::sin(u), std::cos(v));
        EXPECT_NEAR(std::abs(c.direction1.dot(meridian)), 1, 1e-12);
        expect_orthonormal(c, jet.gradient);
    }
}

TEST(Curvature, OfACylinderIsZeroAlongIt) {
    Random random(3);
    for (int i = 0; i < 1000; ++i) {
        const Vec3d axis = test::random_point(random, -1, 1).normalized();
        const AnalyticField cylinder = cylinder_field(Vec3d::Zero(), axis, 0.5);
        const Vec3d away = axis.cross(test::random_point(random, -1, 1)).normalized();
        const Jet jet = cylinder.jet(0.5 * away + test::random_real(random, -2, 2) * axis);
        const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
        EXPECT_NEAR(c.k1, 2, 1e-12);
        EXPECT_NEAR(c.k2, 0, 1e-12);
        EXPECT_NEAR(std::abs(c.direction2.dot(axis)), 1, 1e-12);
    }
}

TEST(NormalCurvature, IsEulersMixOfThePrincipalOnes) {
    Random random(8);
    for (const std::string_view name : {"gyroid", "cube", "torus"}) {
        const AnalyticField field = builtin_field(name);
        for (int i = 0; i < 1000; ++i) {
            const Jet jet = field.jet(test::random_point(random, -0.9, 0.9));
            const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
            const double angle = test::random_real(random, -3, 3);
            const Vec3d tangent = std::cos(angle) * c.direction1 + std::sin(angle) * c.direction2;
            // Of a direction, only the tangential part counts.
            const Vec3d direction = test::random_real(random, 0.1, 10) * tangent +
                                    test::random_real(random, -10, 10) * jet.gradient.normalized();
            const double expected =
                c.k1 * std::pow(std::cos(angle), 2) + c.k2 * std::pow(std::sin(angle), 2);
            // 100: how much longer than its tangential part a direction may be.
            EXPECT_NEAR(normal_curvature(jet.gradient, jet.hessian, direction), expected,
                        100 * tolerance * std::max(1.0, std::abs(c.k1) + std::abs(c.k2)));
        }
    }
    EXPECT_EQ(normal_curvature(Vec3d::UnitX(), Mat3d::Ones(), Vec3d::UnitX()), 0);
    EXPECT_EQ(normal_curvature(Vec3d::Zero(), Mat3d::Ones(), Vec3d::UnitX()), 0);
}

TEST(FlowLineCurvature, IsHowFastTheNormalTurnsAlongIt) {
    Random random(9);
    for (const std::string_view name : {"gyroid", "cube", "saddle", "marschner-lobb"}) {
        const AnalyticField field = builtin_field(name);
        for (int i = 0; i < 1000; ++i) {
            const Vec3d p = test::random_point(random, -0.9, 0.9);
            const Jet jet = field.jet(p);
            const double length = jet.gradient.norm();
            if (length < 0.3) continue; // where lines may bend at any rate
            constexpr double step = 1e-6;
            const Vec3d n = jet.gradient / length;
            const double turning = (field.jet(p + step * n).gradient.normalized() -
                                    field.jet(p - step * n).gradient.normalized())
                                       .norm() /
                                   (2 * step);
            // Lines turn by at most 400 per unit here, and differences err by (400 step)^2 of that;
            // roundings by 2^-52/step.
            EXPECT_NEAR(flow_line_curvature(jet.gradient, jet.hessian), turning,
                        1e-6 * std::max(1.0, turning));
        }
    }
    EXPECT_EQ(flow_line_curvature(Vec3d::Zero(), Mat3d::Ones()), 0);
}

TEST(FlowLineCurvature, IsZeroOfDistances) {
    Random random(10);
    for (const std::string_view name : {"sphere", "torus", "cylinder"}) {
        const AnalyticField field = builtin_field(name);
        for (int i = 0; i < 1000; ++i) {
            const Jet jet = field.jet(test::random_point(random, -1.4, 1.4));
            // The Hessian is at most 1/distance to where distances have no derivative.
            EXPECT_LT(flow_line_curvature(jet.gradient, jet.hessian),
                      tolerance * std::max(1.0, jet.hessian.norm()));
        }
    }
}

TEST(Curvature, OfASaddleIsOneAndMinusOne) {
    const Jet jet = builtin_field("saddle").jet(Vec3d::Zero());
    const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
    EXPECT_NEAR(c.k1, 1, tolerance);
    EXPECT_NEAR(c.k2, -1, tolerance);
}

/// H d = k |g| d within the tangent plane, whatever the normal: towards the poles, where bases
/// break, along axes, where entries vanish.
TEST(Curvature, SolvesTheEigenproblemForAnyNormal) {
    Random random(4);
    std::vector<Vec3d> normals{Vec3d::UnitX(),  Vec3d::UnitY(),        Vec3d::UnitZ(),
                               -Vec3d::UnitX(), -Vec3d::UnitY(),       -Vec3d::UnitZ(),
                               {1e-9, 0, -1},   {-1e-300, 1e-300, -1}, {1e-17, -1e-17, 1}};
    for (int i = 0; i < 1000; ++i) normals.push_back(test::random_point(random, -1, 1));
    for (const Vec3d& normal : normals) {
        const Vec3d n = normal.normalized();
        const double length = std::exp2(test::random_real(random, -30, 30));
        Mat3d h = Mat3d::NullaryExpr([&] { return test::random_real(random, -1, 1); });
        h = (h + h.transpose()).eval();
        const Curvatures c = principal_curvatures(length * n, h);
        EXPECT_GE(c.k1, c.k2);
        expect_orthonormal(c, n);
        const Mat3d tangential = Mat3d::Identity() - n * n.transpose();
        const double scale = h.norm() / length;
        for (const auto& [k, d] : {std::pair{c.k1, c.direction1}, std::pair{c.k2, c.direction2}})
            EXPECT_LE((tangential * h * d / length - k * d).norm(), 1e-12 * scale);
    }
}

/// RMS error of k1 and k2 on the torus, by the interpolating spline of its samples.
constexpr double minor = 0.4;
double rms_on_the_torus(int samples_per_axis, std::optional<double> half_width_voxels) {
    constexpr double major = 1;
    const AnalyticField torus =
        torus_field(Vec3d(0.011, -0.007, 0.003), {0.3, 1, 0.5}, major, minor);
    AnalyticField in_a_cube = torus;
    in_a_cube.half_extent_world = 1.75;
    const auto control = control_samples(sampled(in_a_cube, samples_per_axis, half_width_voxels),
                                         Filter::Interpolating);
    Random random(6);
    double squares = 0;
    int count = 0;
    while (count < 400) {
        Vec3d p = test::random_point(random, -1.5, 1.5);
        const Jet near = torus.jet(p);
        if (std::abs(near.value) > 0.2) continue;
        p -= near.value * near.gradient; // onto the torus
        ++count;
        const Jet jet = tricubic_jet(*control, control->space().to_index(p));
        const Curvatures c = principal_curvatures(control->space().gradient_to_world(jet.gradient),
                                                  control->space().hessian_to_world(jet.hessian));
        const Jet exact = torus.jet(p);
        const Curvatures e = principal_curvatures(exact.gradient, exact.hessian);
        squares += (std::pow(c.k1 - e.k1, 2) + std::pow(c.k2 - e.k2, 2)) / 2;
    }
    return std::sqrt(squares / count);
}

/// The spline's second derivatives are of second order: as long as the band holds all that the
/// control samples around a hit are made of, which is as far as 2 sqrt 3 + 1 = 4.5 voxels.
TEST(Curvature, ConvergesAtSecondOrderInABandOfFiveVoxels) {
    for (const std::optional<double> half_width : {std::optional<double>{}, {5.0}}) {
        double before = rms_on_the_torus(48, half_width);
        // (1/12) of fourth derivatives, at most 15/0.4^3, at voxels of 3.5/47; the RMS is a third.
        EXPECT_LT(before, 15 / std::pow(minor, 3) / 12 * std::pow(3.5 / 47, 2) / 3);
        for (const int n : {95, 189}) { // half the voxel each time
            const double after = rms_on_the_torus(n, half_width);
            // 2^2, less what the fourth order still has at 5 voxels in the minor radius.
            EXPECT_GT(before / after, 3.6) << n;
            EXPECT_LT(before / after, 4.4) << n;
            before = after;
        }
    }
    // In a narrower one the error stays where it reaches the band's edge.
    EXPECT_LT(rms_on_the_torus(95, 3.0) / rms_on_the_torus(189, 3.0), 3.6);
}

/// Eq. 6.8 as printed is the zero vector here.
TEST(Curvature, HasDirectionsWhereTheBasisIsPrincipalAndAtUmbilics) {
    for (const Vec3d& pure : {Vec3d(3, 1, 0), Vec3d(1, 3, 0), Vec3d(2, 2, 0), Vec3d(0, 0, 5)}) {
        const Curvatures c = principal_curvatures(Vec3d::UnitZ(), pure.asDiagonal());
        EXPECT_EQ(c.k1, std::max(pure.x(), pure.y()));
        EXPECT_EQ(c.k2, std::min(pure.x(), pure.y()));
        expect_orthonormal(c, Vec3d::UnitZ());
        if (pure.x() > pure.y()) {
            EXPECT_EQ(std::abs(c.direction1.x()), 1);
        }
        if (pure.x() < pure.y()) {
            EXPECT_EQ(std::abs(c.direction1.y()), 1);
        }
    }
}

TEST(Curvature, IsZeroWhereTheGradientVanishes) {
    for (const double x : {0.0, -0.0}) {
        const Curvatures c = principal_curvatures(Vec3d(x, 0, 0), Mat3d::Ones());
        EXPECT_EQ(c.k1, 0);
        EXPECT_EQ(c.k2, 0);
        EXPECT_EQ(c.direction1, Vec3d::Zero());
    }
}

} // namespace
} // namespace isocast
