// Fields on other lattices, and morphs of fields on two.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/morph.h"

#include "../volume/random_fields.h"
#include "filtering/reconstruct.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"

#include <cmath>

namespace isocast::test {
namespace {

std::shared_ptr<const FieldSource> shared(AnalyticField field, int n,
                                          std::optional<double> half_width_voxels = {},
                                          double half_extent_world = 1) {
    field.half_extent_world = half_extent_world;
    return sampled(std::move(field), n, half_width_voxels);
}

/// A lattice that is turned and stretched, inside [-1, 1]^3 in all of 0 ... n - 1.
GridSpace turned(int n) {
    GridSpace space;
    space.world_from_index.linear() =
        Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()).toRotationMatrix() *
        Vec3d(0.9, 0.8, 1).asDiagonal() * (1.0 / (n - 1));
    space.world_from_index.translation() =
        -space.world_from_index.linear() * Vec3d::Constant(0.5 * (n - 1));
    return space;
}

TEST(Resampled, IsTheFiltersFunction) {
    Random random(1);
    const auto noise =
        std::make_shared<DenseField>(random_dense(random, {Index3(-5, 0, 3), Index3(20, 18, 25)}));
    GridSpace space = turned(20);
    space.world_from_index.linear() *= 12;
    space.world_from_index.translation() = Vec3d(-4, 2, 3);
    const IndexBox extent{Index3(0, 1, -2), Index3(20, 18, 17)};
    for (const Filter filter : {Filter::Linear, Filter::Interpolating, Filter::CatmullRom}) {
        const auto control = control_samples(noise, filter);
        const auto found = resampled(noise, filter, space, extent);
        for_each_sample(extent, [&](const Index3& index) {
            const Vec3d p = noise->space()
                                .to_index(space.to_world(index.cast<double>()))
                                .cwiseMax(Vec3d(-5, 0, 3))
                                .cwiseMin(Vec3d(19, 17, 24));
            // Rounded to float once; 1e-12: places in double, at slopes of a few.
            const double value = kernel_value(*control, p, kernel_of(filter));
            EXPECT_NEAR(sample(*found, index), value, std::abs(value) * 0x1p-24 + 1e-12);
        });
    }
}

TEST(Resampled, ConvergesAtFourthOrder) {
    const AnalyticField torus = torus_field(Vec3d::Zero(), {1, 2, 3}, 0.6, 0.25);
    std::array<double, 2> errors{};
    for (const std::size_t i : {0U, 1U}) {
        const int n = i == 0 ? 33 : 65;
        const GridSpace space = turned(40);
        const IndexBox extent{Index3::Zero(), Index3::Constant(40)};
        const auto found = resampled(shared(torus, n), Filter::Interpolating, space, extent);
        int count = 0;
        for_each_sample(extent, [&](const Index3& index) {
            const double exact = torus.jet(space.to_world(index.cast<double>())).value;
            if (std::abs(exact) > 0.1) return; // away from where a distance bends
            ++count;
            errors[i] += std::pow(sample(*found, index) - exact, 2);
        });
        errors[i] = std::sqrt(errors[i] / count);
    }
    // 16 for exact fourth order; higher terms take off some on the coarse grid.
    EXPECT_GT(errors[0] / errors[1], 12);
    EXPECT_LT(errors[1], 2e-5);
}

TEST(Resampled, KeepsABandsSignsAndWidth) {
    const auto band = shared(sphere_field(Vec3d::Zero(), 0.6), 48, 3);
    const double half_width = band->half_width_world().value();
    const GridSpace space = turned(40);
    const IndexBox extent{Index3::Constant(-20), Index3::Constant(60)};
    const auto found = resampled(band, Filter::Interpolating, space, extent);
    EXPECT_EQ(found->half_width_world(), half_width);
    for_each_sample(extent, [&](const Index3& index) {
        const double exact = space.to_world(index.cast<double>()).norm() - 0.6;
        const float value = sample(*found, index);
        EXPECT_LE(std::abs(value), static_cast<float>(half_width));
        // Four voxels beyond the band, more than support and stencil reach, it is all background.
        if (std::abs(exact) > 7.0 / 3 * half_width) {
            EXPECT_EQ(value, static_cast<float>(std::copysign(half_width, exact)));
        } else if (std::abs(exact) > 0.01) {
            EXPECT_EQ(value < 0, exact < 0);
        }
    });
}

TEST(Morph, IsTheOperandItselfAtTheEnds) {
    const auto a = shared(builtin_field("sphere"), 32);
    const auto b = shared(builtin_field("torus"), 40);
    EXPECT_EQ(morph(a, b, 0).field, a);
    EXPECT_EQ(morph(a, b, 1).field, b);
    EXPECT_THROW(morph(a, b, -0.1), InputError);
    EXPECT_THROW(morph(a, b, std::nan("")), InputError);
}

TEST(Morph, TakesTheFinerLatticeAndTheExtentOfBoth) {
    const auto coarse = shared(sphere_field(Vec3d::Zero(), 0.6), 20);
    const auto fine = shared(sphere_field(Vec3d::Zero(), 0.3), 40, {}, 0.6);
    for (const bool is_fine_first : {true, false}) {
        const Morph m = is_fine_first ? morph(fine, coarse, 0.25) : morph(coarse, fine, 0.75);
        EXPECT_EQ(m.field->space().world_from_index.matrix(),
                  fine->space().world_from_index.matrix());
        EXPECT_FALSE(m.warning);
        for (const int corner : {0, 39}) {
            const double p = corner == 0 ? -1 : 1;
            const Vec3d index = fine->space().to_index(Vec3d::Constant(p));
            EXPECT_TRUE(m.field->extent().contains(index.array().round().cast<int>().matrix()));
        }
        // 3/4 of |p| - 0.3 and 1/4 of |p| - 0.6, in the finer one's extent; the coarse one errs by
        // 0.002 of a voxel of 0.1.
        for (const Vec3d& p : {Vec3d(0.4, 0, 0), Vec3d(0.1, 0.2, -0.3), Vec3d(-0.3, 0.3, 0.1)})
            EXPECT_NEAR(kernel_value(*control_samples(m.field, Filter::Interpolating),
                                     fine->space().to_index(p), Kernel::BSpline),
                        p.norm() - 0.75 * 0.3 - 0.25 * 0.6, 1e-3);
    }
}

TEST(Morph, WarnsOfBandsThatDoNotMeet) {
    const auto small = shared(sphere_field(Vec3d::Zero(), 0.4), 65, 3);
    const auto large = shared(sphere_field(Vec3d::Zero(), 0.8), 49, 3); // another lattice
    const auto warning = morph(small, large, 0.5).warning;
    ASSERT_TRUE(warning);
    EXPECT_NE(warning->find("do not meet"), std::string::npos);
    EXPECT_FALSE(morph(small, small, 0.5).warning);
}

} // namespace
} // namespace isocast::test
