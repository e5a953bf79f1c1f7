// The reference caster against closed forms and plain sampling; and that the hard fields are as
// hard as they say.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/reference.h"

#include "filtering/reconstruct.h"
#include "hard_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace isocast {
namespace {

using namespace test;
constexpr std::array kernels{Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom};

TEST(ReferenceCaster, HitsPlanesAtTheirDistance) {
    // Eighths: exact in float; every kernel reproduces linears.
    const Vec3d slope(0.5, -0.25, 0.875);
    const Vec3d middle(8, 8, 8);
    const auto field = control_of(17, [&](const Vec3d& p) { return slope.dot(p - middle); });
    Random random(1);
    for (const Kernel kernel : kernels) {
        const ReferenceCaster caster(*field, 0.125, {.kernel = kernel});
        int hits = 0;
        for (int i = 0; i < 300; ++i) {
            const Ray ray = random_ray(random, 17);
            const double t =
                (0.125 - slope.dot(ray.origin_world - middle)) / slope.dot(ray.direction_world);
            const Vec3d p = ray.origin_world + t * ray.direction_world;
            // Within a voxel of the border the control samples that repeat it bend the plane.
            const auto is_clear_by = [&](double d) {
                return (p.array() > d).all() && (p.array() < 16 - d).all();
            };
            if (is_clear_by(-1) && !is_clear_by(1)) continue;
            const auto hit = caster.hit(ray);
            ASSERT_EQ(hit.has_value(), is_clear_by(1)) << i;
            if (!hit) continue;
            ++hits;
            // Bisection to 1e-12; coordinates of 40 round to 7e-15 some times, along a grazing ray
            // divided by its slope.
            EXPECT_NEAR(*hit, t, 1e-12 + 1e-13 / std::abs(slope.dot(ray.direction_world)));
        }
        EXPECT_GT(hits, 100);
    }
}

TEST(ReferenceCaster, HitsSpheresThatTheKernelReproduces) {
    // |p - c|^2 - R^2 with quarters: exact in float. Its Laplacian is 6: the B-spline adds 1.
    const Vec3d centre(12.25, 11.5, 12.75);
    const double radius = 8;
    Random random(2);
    for (const Kernel kernel : {Kernel::BSpline, Kernel::CatmullRom}) {
        const double iso = kernel == Kernel::BSpline ? 1 : 0;
        const auto field = control_of(
            25, [&](const Vec3d& p) { return (p - centre).squaredNorm() - radius * radius; });
        const ReferenceCaster caster(*field, iso, {.kernel = kernel});
        for (int i = 0; i < 1000; ++i) {
            const bool from_inside = i % 3 == 0;
            Ray ray = random_ray(random, 25);
            if (from_inside) ray.origin_world = centre + random_point(random, -4, 4);
            const Vec3d o = ray.origin_world - centre;
            const double b = o.dot(ray.direction_world);
            const double h = radius * radius - (o - b * ray.direction_world).squaredNorm();
            const auto hit = caster.hit(ray);
            // A chord that is shorter than a step of 1/64 may be missed.
            if (h > 0 && 2 * std::sqrt(h) < 1.0 / 64) continue;
            ASSERT_EQ(hit.has_value(), h > 0) << i;
            if (!hit) continue;
            // Bisection to 1e-12; values of 1000 round to 1e-13 a few times, and the slope there is
            // twice the half chord.
            EXPECT_NEAR(*hit, -b + (from_inside ? 1 : -1) * std::sqrt(h),
                        1e-12 + 3e-13 / (2 * std::sqrt(h)));
        }
    }
}

/// The first change of sign of the samples at the same places, none skipped, each by the field
/// source and the twin of the shaders; between them nothing is sought.
std::optional<double> sampled_hit(const FieldSource& field, double iso, const Ray& ray,
                                  Kernel kernel, double step, double t_begin, double t_end) {
    std::optional<bool> before;
    for (double t = t_begin; t < t_end; t += step) {
        const bool inside =
            kernel_value(field, ray.origin_world + t * ray.direction_world, kernel) - iso < 0;
        if (before && inside != *before) return t;
        before = inside;
    }
    return std::nullopt;
}

TEST(ReferenceCaster, SkipsNoCellThatHoldsARoot) {
    Random random(3);
    const IndexBox extent{Index3::Zero(), Index3::Constant(12)};
    for (const Kernel kernel : kernels) {
        int hits = 0;
        for (int round = 0; round < 6; ++round) {
            // Mostly outside, so that cells are skipped; the rest low enough for the B-spline,
            // which takes (2/3)^3 of it, to dip below zero.
            std::vector<float> values(12 * 12 * 12);
            for (float& value : values) {
                value = random_int(random, 0, 20) == 0
                            ? -6.0f
                            : static_cast<float>(random_real(random, 0, 1));
            }
            const DenseField field(GridSpace::uniform(1), extent, values);
            const double step = 1.0 / 64;
            const ReferenceCaster caster(field, 0, {.kernel = kernel, .step_voxels = step});
            for (int i = 0; i < 60; ++i) {
                const Vec3d from = random_point(random, 0.01, 10.99);
                const Ray ray{from, random_point(random, -1, 1).normalized()};
                double t_end = 1e30;
                for (int axis = 0; axis < 3; ++axis) {
                    const double d = ray.direction_world[axis];
                    t_end = std::min(t_end, ((d > 0 ? 11 : 0) - from[axis]) / d);
                }
                const auto expected = sampled_hit(field, 0, ray, kernel, step, 0, t_end);
                const auto hit = caster.hit(ray);
                // The caster also looks at the very end of the ray.
                if (!expected) {
                    EXPECT_GT(hit.value_or(t_end), t_end - step);
                    continue;
                }
                ++hits;
                ASSERT_TRUE(hit) << i;
                EXPECT_GE(*hit, *expected - step - 1e-12); // sums of t in another order
                EXPECT_LE(*hit, *expected + 1e-12);
            }
        }
        EXPECT_GT(hits, 100);
    }
}

TEST(ReferenceCaster, FindsWhereCatmullRomUndershootsPositiveSamples) {
    // 1, 0.01, 0.01, 1 along x: half way (-1 + 9 * 0.01 + 9 * 0.01 - 1)/16 < 0.
    const auto field =
        control_of(8, [](const Vec3d& p) { return p.x() == 3 || p.x() == 4 ? 0.01 : 1.0; });
    const Ray ray{{-5, 3.3, 3.7}, Vec3d::UnitX()};
    EXPECT_FALSE(ReferenceCaster(*field, 0).hit(ray));
    EXPECT_FALSE(ReferenceCaster(*field, 0, {.kernel = Kernel::Linear}).hit(ray));
    const auto hit = ReferenceCaster(*field, 0, {.kernel = Kernel::CatmullRom}).hit(ray);
    ASSERT_TRUE(hit);
    EXPECT_GT(*hit, 8);
    EXPECT_LT(*hit, 8.5);
}

TEST(ReferenceCaster, KeepsToTheExtentAndToTheRay) {
    const auto field = control_of(9, [](const Vec3d& p) { return 4.5 - p.x(); });
    const ReferenceCaster caster(*field, 0);
    const auto t = [&](const Vec3d& origin, const Vec3d& direction) {
        return caster.hit({origin, direction});
    };
    EXPECT_NEAR(t({-10, 4, 4}, {2, 0, 0}).value(), 7.25, 1e-11); // not normalised
    EXPECT_NEAR(t({5, 4, 4}, {-1, 0, 0}).value(), 0.5, 1e-11);   // from inside
    EXPECT_FALSE(t({5, 4, 4}, {1, 0, 0}));                       // behind
    EXPECT_FALSE(t({-10, 8.5, 4}, {1, 0, 0}));                   // beside the extent
    EXPECT_FALSE(t({-10, 4, 4}, {0, 1, 0}));                     // past it
    EXPECT_FALSE(t({20, 4, 4}, {1, 0, 0}));                      // away from it
    EXPECT_NEAR(t({-10, 8, 0}, {1, 0, 0}).value(), 14.5, 1e-11); // along an edge
}

TEST(ReferenceCaster, CastsInWorldSpace) {
    GridSpace space;
    space.world_from_index.linear() << 0.9, 0.2, 0.0, -0.1, 1.1, 0.3, 0.1, 0.0, -0.8;
    space.world_from_index.translation() = Vec3d(100, -200, 50);
    const auto unit = smooth_noise(24, 4).control;
    const DenseField field(space, unit->extent(),
                           std::vector(unit->values().begin(), unit->values().end()));
    const ReferenceCaster in_index(*unit, 0);
    const ReferenceCaster in_world(field, 0);
    Random random(5);
    int hits = 0;
    for (int i = 0; i < 200; ++i) {
        const Ray ray = random_ray(random, 24);
        const Ray mapped{space.to_world(ray.origin_world),
                         space.world_from_index.linear() * ray.direction_world};
        const auto a = in_index.hit(ray);
        const auto b = in_world.hit(mapped);
        ASSERT_EQ(a.has_value(), b.has_value());
        if (!a) continue;
        ++hits;
        // World coordinates of 200 round to 3e-14; a grazing root takes the square root of that.
        EXPECT_NEAR(*a, *b, 1e-6);
        EXPECT_EQ(reference_hit(*unit, 0, ray), a);
    }
    EXPECT_GT(hits, 100);
}

TEST(HardFields, SheetIsAsThinAsItSays) {
    Random random(6);
    for (unsigned seed = 1; seed <= 4; ++seed) {
        const ThinSheet sheet = thin_sheet(32, seed);
        const double w = sheet.field.thickness_voxels / 2;
        const ReferenceCaster caster(*sheet.field.control, 0, {.step_voxels = w / 2});
        int hits = 0;
        for (int i = 0; i < 200; ++i) {
            const Ray ray = random_ray(random, 32);
            const double slope = sheet.normal.dot(ray.direction_world);
            const double t = sheet.normal.dot(sheet.p_on_sheet - ray.origin_world) / slope;
            const Vec3d p = ray.origin_world + t * ray.direction_world;
            // Away from the border, where control samples are clamped.
            if ((p.array() < 3).any() || (p.array() > 28).any()) continue;
            ++hits;
            const auto hit = caster.hit(ray);
            ASSERT_TRUE(hit);
            // Near the face s = w the slope is 2w/8; samples of 2 round to 1.2e-7, their mean to
            // less: 5e-5, less than a hundredth of w. Likewise on the other side.
            EXPECT_NEAR((*hit - t) * std::abs(slope), -w, 0.01 * w);
            const auto far_face =
                caster.hit({ray.origin_world + 1000 * ray.direction_world, -ray.direction_world});
            ASSERT_TRUE(far_face);
            EXPECT_NEAR((1000 - *far_face - t) * std::abs(slope), w, 0.01 * w);
        }
        EXPECT_GT(hits, 50);
    }
}

TEST(HardFields, ShellIsAsThinAsItSays) {
    Random random(7);
    const ThinShell shell = thin_shell(48, 1);
    const double w = shell.field.thickness_voxels / 2;
    const ReferenceCaster caster(*shell.field.control, 0, {.step_voxels = w / 4});
    for (int i = 0; i < 200; ++i) {
        const Vec3d direction = random_point(random, -1, 1).normalized();
        const auto inner = caster.hit({shell.centre, direction});
        const auto outer = caster.hit({shell.centre + (shell.radius + 5) * direction, -direction});
        ASSERT_TRUE(inner && outer);
        EXPECT_NEAR(*inner, shell.radius - w, 0.2 * w);
        EXPECT_NEAR(shell.radius + 5 - *outer, shell.radius + w, 0.2 * w);
    }
}

TEST(HardFields, NeedlesAreThereAndThin) {
    const HardField field = needles(48, 1);
    const ReferenceCaster caster(*field.control, 0, {.step_voxels = 0.02});
    Random random(8);
    std::vector<double> widths;
    for (int i = 0; i < 4000; ++i) {
        const double y = random_real(random, 3, 44);
        const double z = random_real(random, 3, 15);
        const auto hit = caster.hit({{-10, y, z}, Vec3d::UnitX()});
        if (!hit) continue;
        const Vec3d inside(-10 + *hit + 1e-3, y, z);
        widths.push_back(caster.hit({inside, Vec3d::UnitX()}).value_or(0));
    }
    // 24 needles 0.5 to 0.6 voxel wide at these heights, over 0.8 * 48 voxels of y: a third of the
    // rays, less what overlaps. Measured 1157, a mean chord of pi/4 * 0.6, and one in a hundred
    // wider than 1.26, where needles meet.
    EXPECT_GT(widths.size(), 800);
    EXPECT_LT(widths.size(), 1400);
    std::ranges::sort(widths);
    EXPECT_LT(widths[widths.size() / 2], 0.6);
    EXPECT_LT(widths[widths.size() * 99 / 100], 1.5);
}

TEST(HardFields, HaveSurfaces) {
    Random random(9);
    for (unsigned seed = 1; seed <= 3; ++seed) {
        for (const HardField& field : hard_fields(32, seed)) {
            const ReferenceCaster caster(*field.control, 0, {.step_voxels = 1.0 / 256});
            int hits = 0;
            for (int i = 0; i < 200; ++i) hits += caster.hit(random_ray(random, 32)).has_value();
            // Measured 36 (needles) to 182 (noise).
            EXPECT_GT(hits, 20) << field.name;
            EXPECT_LT(hits, 200) << field.name;
        }
    }
}

} // namespace
} // namespace isocast
