// The certified caster against closed forms, and against brute force on fields that ray casters
// miss.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/certified_caster.h"

#include "filtering/reconstruct.h"
#include "hard_fields.h"
#include "raycaster/reference.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace isocast {
namespace {

using namespace test;
constexpr std::array kernels{Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom};

std::vector<double> changes_along(const CertifiedCaster& caster, const Ray& ray) {
    std::vector<double> changes;
    CertifiedCaster::Walk walk = caster.walk(ray);
    while (const auto t = walk.next()) changes.push_back(*t);
    return changes;
}

TEST(CertifiedCaster, FindsAllThreeRootsOfACubicInOneCell) {
    // (x - a)(x - b)(x - c) is the spline of the samples f - f''/6.
    const Vec3d roots(4.25, 4.5, 4.875);
    const auto field = control_of(9, [&](const Vec3d& p) {
        return (p.x() - roots.array()).prod() - (p.x() - roots.sum() / 3);
    });
    const CertifiedCaster caster(field, Kernel::BSpline, 0);
    for (const Vec3d& direction : {Vec3d(1, 0, 0), Vec3d(-1, 0, 0), Vec3d(2, 0.1, -0.3)}) {
        const Vec3d from = Vec3d(4.6, 4.1, 3.7) - 2 * direction;
        std::vector<double> changes = changes_along(caster, {from, direction});
        ASSERT_EQ(changes.size(), 3U);
        if (direction.x() < 0) std::ranges::reverse(changes);
        for (int i = 0; i < 3; ++i) {
            const double expected = (roots[i] - from.x()) / direction.x();
            // Samples up to 8 round to 2.4e-7; slopes are 0.09 and more, along x.
            EXPECT_NEAR(changes[static_cast<std::size_t>(i)], expected, 3e-6) << i;
        }
    }
}

TEST(CertifiedCaster, FindsSheetsOfAnyThicknessAndNothingWhereRaysJustMiss) {
    // (x - 4.5)^2: quarters, exact in float; the B-spline adds a third, Catmull-Rom's cubic
    // nothing.
    const auto field = control_of(10, [](const Vec3d& p) { return std::pow(p.x() - 4.5, 2); });
    const Ray ray{{-3, 4.2, 4.9}, {1, 0.01, -0.02}};
    for (const Kernel kernel : {Kernel::BSpline, Kernel::CatmullRom}) {
        const double least = kernel == Kernel::BSpline ? 1.0 / 3 : 0;
        for (const double half : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5}) {
            const std::vector<double> changes =
                changes_along({field, kernel, least + half * half}, ray);
            ASSERT_EQ(changes.size(), 2U) << half;
            // Values to 2^-46 of samples up to 4, by a slope of twice the half thickness.
            const double error = 4 * 0x1p-46 / (2 * half);
            EXPECT_NEAR(changes[0], 7.5 - half, error);
            EXPECT_NEAR(changes[1], 7.5 + half, error);
            EXPECT_TRUE(changes_along({field, kernel, least - half * half}, ray).empty()) << half;
        }
    }
}

TEST(CertifiedCaster, HitsSpheresThatTheKernelReproduces) {
    // As ReferenceCaster.HitsSpheresThatTheKernelReproduces, but for chords as short as they come.
    const Vec3d centre(12.25, 11.5, 12.75);
    const double radius = 8;
    const auto field = control_of(
        25, [&](const Vec3d& p) { return (p - centre).squaredNorm() - radius * radius; });
    Random random(2);
    for (const Kernel kernel : {Kernel::BSpline, Kernel::CatmullRom}) {
        const CertifiedCaster caster(field, kernel, kernel == Kernel::BSpline ? 1 : 0);
        for (int i = 0; i < 2000; ++i) {
            Ray ray = random_ray(random, 25);
            // Every other one grazes: chords down to 2 * 4e-6.
            const double depth = std::pow(10.0, -random_real(random, 1, 12));
            if (i % 2 == 0) {
                const Vec3d across = ray.direction_world.cross(random_point(random, -1, 1));
                ray.origin_world =
                    centre + (radius - depth) * across.normalized() - 40 * ray.direction_world;
            }
            const Vec3d o = ray.origin_world - centre;
            const double b = o.dot(ray.direction_world);
            const double h = radius * radius - (o - b * ray.direction_world).squaredNorm();
            // Values to 2^-46 of samples up to 90 in the cells there, and the ray's own roundings.
            const double error = 2e-12;
            if (std::abs(h) < error) continue;
            const std::vector<double> changes = changes_along(caster, ray);
            ASSERT_EQ(changes.size(), h > 0 ? 2U : 0U) << i << ' ' << h;
            if (h < 0) continue;
            const double half = std::sqrt(h);
            EXPECT_NEAR(changes[0], -b - half, error / half);
            EXPECT_NEAR(changes[1], -b + half, error / half);
        }
    }
}

TEST(CertifiedCaster, MissesNothingThatBruteForceFinds) {
    Random random(3);
    std::vector<std::shared_ptr<const DenseField>> fields;
    for (const HardField& field : hard_fields(32, 7)) fields.push_back(field.control);
    fields.push_back(
        std::make_shared<DenseField>(random_dense(random, {Index3::Zero(), Index3::Constant(32)})));
    for (const Kernel kernel : kernels) {
        int hits = 0;
        for (const auto& field : fields) {
            const CertifiedCaster caster(field, kernel, 0);
            const ReferenceCaster force(*field, 0, {.kernel = kernel, .step_voxels = 1.0 / 128});
            for (int i = 0; i < 150; ++i) {
                const Ray ray = random_ray(random, 32);
                const std::vector<double> changes = changes_along(caster, ray);
                // Between two changes the function has the sign that it says.
                bool is_inside = caster.walk(ray).starts_inside();
                for (std::size_t k = 0; k + 1 < changes.size(); ++k) {
                    is_inside = !is_inside;
                    const double t = (changes[k] + changes[k + 1]) / 2;
                    const double value =
                        kernel_value(*field, ray.origin_world + t * ray.direction_world, kernel);
                    // 2^-46 of samples up to 24.
                    if (std::abs(value) > 4e-13) {
                        EXPECT_EQ(value < 0, is_inside) << t;
                    }
                }
                const auto expected = force.hit(ray);
                if (!expected) continue;
                ++hits;
                // The step may hold three changes, of which force finds any.
                const bool is_found = std::ranges::any_of(
                    changes, [&](double t) { return std::abs(t - *expected) < 1e-9; });
                EXPECT_TRUE(is_found) << *expected;
            }
        }
        EXPECT_GT(hits, 400);
    }
}

TEST(CertifiedCaster, FindsTheSameFromTheOtherEnd) {
    Random random(4);
    const auto field =
        std::make_shared<DenseField>(random_dense(random, {Index3::Zero(), Index3::Constant(40)}));
    for (const Kernel kernel : kernels) {
        const CertifiedCaster caster(field, kernel, 0);
        for (int i = 0; i < 100; ++i) {
            const Ray there = random_ray(random, 40);
            const double length = 160;
            const Ray back{there.origin_world + length * there.direction_world,
                           -there.direction_world};
            const std::vector<double> changes = changes_along(caster, there);
            std::vector<double> reversed = changes_along(caster, back);
            std::ranges::reverse(reversed);
            ASSERT_EQ(changes.size(), reversed.size());
            for (std::size_t k = 0; k < changes.size(); ++k)
                EXPECT_NEAR(changes[k], length - reversed[k], 1e-9); // of slopes of 1e-4 and more
            // Odd where the ray ends on the other side.
            EXPECT_EQ(changes.size() % 2 == 1,
                      caster.walk(there).starts_inside() != caster.walk(back).starts_inside());
        }
    }
}

TEST(CertifiedCaster, KeepsToTheExtentAndToTheRay) {
    const auto field = control_of(9, [](const Vec3d& p) { return 4.5 - p.x(); });
    for (const Kernel kernel : kernels) {
        const CertifiedCaster caster(field, kernel, 0);
        const auto t = [&](const Vec3d& origin, const Vec3d& direction) {
            return caster.hit({origin, direction});
        };
        EXPECT_NEAR(t({-10, 4, 4}, {2, 0, 0}).value(), 7.25, 1e-13); // not normalised
        EXPECT_NEAR(t({5, 4, 4}, {-1, 0, 0}).value(), 0.5, 1e-13);   // from inside
        EXPECT_FALSE(t({5, 4, 4}, {1, 0, 0}));                       // behind
        EXPECT_FALSE(t({-10, 8.5, 4}, {1, 0, 0}));                   // beside the extent
        EXPECT_FALSE(t({-10, 4, 4}, {0, 1, 0}));                     // past it
        EXPECT_FALSE(t({20, 4, 4}, {1, 0, 0}));                      // away from it
        EXPECT_NEAR(t({-10, 8, 0}, {1, 0, 0}).value(), 14.5, 1e-13); // along an edge
        EXPECT_TRUE(caster.walk({{5, 4, 4}, {1, 0, 0}}).starts_inside());
        EXPECT_FALSE(caster.walk({{-5, 4, 4}, {1, 0, 0}}).starts_inside());
        EXPECT_FALSE(caster.walk({{-5, 14, 4}, {1, 0, 0}}).starts_inside());
        EXPECT_TRUE(caster.walk({{15, 4, 4}, {-1, 0, 0}}).starts_inside()); // where it enters
    }
}

TEST(CertifiedCaster, EndsOnPlateausAtTheIsoValueAndOnFieldsOfASample) {
    const auto plateau = control_of(12, [](const Vec3d& p) { return p.x() < 8 ? 0.0 : 8 - p.x(); });
    for (const Kernel kernel : kernels) {
        // Zero is outside, so that the ray comes in where the plateau ends: Catmull-Rom's cubic and
        // the trilinear interpolant at the last sample that is zero, the B-spline at the first
        // whose neighbour is not.
        const double expected = kernel == Kernel::BSpline ? 7 : 8;
        // Cubic from there: values below 2^-46 of the samples reach to 2e-5.
        EXPECT_NEAR(CertifiedCaster(plateau, kernel, 0).hit({{-1, 5, 5}, {1, 0, 0}}).value() - 1,
                    expected, 5e-5);
        const auto zero = control_of(12, [](const Vec3d&) { return 0.0; });
        EXPECT_FALSE(CertifiedCaster(zero, kernel, 0).hit({{-1, 5, 5}, {1, 0.1, 0}}));
        const auto sample = control_of(1, [](const Vec3d&) { return -1.0; });
        EXPECT_FALSE(CertifiedCaster(sample, kernel, 0).hit({{-1, 0, 0}, {1, 0, 0}}));
    }
}

TEST(CertifiedCaster, IsAsExactFromAfar) {
    // A sphere of 8 voxels from 1e6 voxels away: t of 1e6 rounds to 1e-10.
    const Vec3d centre(12.25, 11.5, 12.75);
    const auto field =
        control_of(25, [&](const Vec3d& p) { return (p - centre).squaredNorm() - 64; });
    const CertifiedCaster caster(field, Kernel::CatmullRom, 0);
    Random random(6);
    for (int i = 0; i < 200; ++i) {
        const Vec3d direction = random_point(random, -1, 1).normalized();
        const Vec3d across = direction.cross(random_point(random, -1, 1)).normalized();
        const double off = random_real(random, 0, 7.9);
        const Vec3d from = centre + off * across - 1e6 * direction;
        const auto hit = caster.hit({from, direction});
        ASSERT_TRUE(hit);
        const double half = std::sqrt(64 - off * off);
        EXPECT_NEAR(*hit, 1e6 - half, 1e-9 * (1 + off / half));
    }
}

} // namespace
} // namespace isocast
