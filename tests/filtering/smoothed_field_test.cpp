// Smoothed fields against what a Gaussian does to polynomials, noise and spheres.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/smoothed_field.h"

#include "../volume/random_fields.h"
#include "filtering/curvature.h"
#include "filtering/filter.h"
#include "filtering/reconstruct.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isocast {
namespace {

using test::Random;

TEST(GaussianWeights, HaveTheVarianceThatIsAsked) {
    for (const double variance : {0.0, 0.01, 0.3, 1.0, 4.0, 50.0, 256.0}) {
        const std::vector<double> w = gaussian_weights(variance);
        double sum = w[0];
        double second = 0;
        for (std::size_t n = 1; n < w.size(); ++n) {
            EXPECT_LE(w[n], w[n - 1]);
            sum += 2 * w[n];
            second += 2 * w[n] * double(n * n);
        }
        EXPECT_NEAR(sum, 1, 1e-14);
        // 1e-6 of the sum is left out, at no more than 6 standard deviations or, of a scale below a
        // voxel, 6 voxels.
        EXPECT_NEAR(second, variance, 1e-6 * 36 * std::max(variance, 1.0));
    }
}

/// e^-2t I_0(2t) is the sum of the squares of e^-t I_n(t): white noise shrinks by that per axis.
TEST(GaussianWeights, TakeFromNoiseWhatTheSemigroupSays) {
    for (const double variance : {0.3, 1.0, 4.0, 50.0}) {
        const std::vector<double> w = gaussian_weights(variance);
        double squares = w[0] * w[0];
        for (std::size_t n = 1; n < w.size(); ++n) squares += 2 * w[n] * w[n];
        const double expected = std::exp(-2 * variance) * std::cyl_bessel_i(0.0, 2 * variance);
        EXPECT_NEAR(squares / expected, 1, 4e-6); // 1e-6 more to each weight, squared
    }
}

/// Samples of a world-space function at 40^3 points of a grid.
template<class Function>
std::shared_ptr<const DenseField> sampled_in(const GridSpace& space, Function f) {
    const IndexBox extent{Index3::Constant(-20), Index3::Constant(20)};
    std::vector<float> values;
    test::for_each_sample(extent, [&](const Index3& i) {
        values.push_back(static_cast<float>(f(space.to_world(i.cast<double>()))));
    });
    return std::make_shared<DenseField>(space, extent, std::move(values));
}

TEST(SmoothedField, OfAQuadraticIsThatAndHalfTheVarianceTimesItsLaplacian) {
    GridSpace turned;
    turned.world_from_index.linear() =
        Eigen::AngleAxisd(0.4, Vec3d(1, 2, 3).normalized()).toRotationMatrix() *
        Vec3d(0.1, 0.13, 0.2).asDiagonal();
    for (const GridSpace& space : {GridSpace::uniform(0.1), turned}) {
        const auto quadratic = [](const Vec3d& p) {
            return 0.3 + p.dot(Vec3d(0.2, -0.5, 0.7)) +
                   p.dot(Vec3d(1, -0.4, 0.3).asDiagonal() * p) + 0.6 * p.x() * p.y();
        };
        const double laplacian = 2 * (1 - 0.4 + 0.3);
        const auto field = sampled_in(space, quadratic);
        for (const double scale : {0.5, 1.0, 2.0}) {
            const SmoothedField smoothed(field, scale);
            // Along every axis the same length: the shortest edge is 0.1.
            const double added = 0.01 * scale * scale / 2 * laplacian;
            for (const Index3& i : {Index3(0, 0, 0), Index3(3, -4, 5), Index3(-6, 2, -1)}) {
                const double expected = quadratic(space.to_world(i.cast<double>())) + added;
                // Samples up to 14 round to floats, and once more for each axis; 3.6e-5 of what is
                // added is left out.
                EXPECT_NEAR(sample(smoothed, i), expected, 14 * 4 * 0x1p-24 + 3.6e-5 * added);
            }
        }
    }
}

TEST(SmoothedField, AtScaleZeroIsTheField) {
    Random random(1);
    const auto noise = std::make_shared<DenseField>(
        test::random_dense(random, {Index3(-3, 0, 2), Index3(9, 11, 10)}));
    const IndexBox box{Index3(-5, -1, 0), Index3(12, 12, 12)};
    EXPECT_EQ(test::copied(SmoothedField(noise, 0), box), test::copied(*noise, box));
}

TEST(SmoothedField, KeepsTheCurvatureOfSpheresInABandTooNarrowForIt) {
    for (const double half_width : {1e6, 3.0}) {
        const Vec3d middle(0.3, -0.2, 0.1);
        const auto field = sampled_in(GridSpace::uniform(1), [&](const Vec3d& p) {
            return std::clamp((p - middle).norm() - 9, -half_width, half_width);
        });
        const auto smoothed = std::make_shared<SmoothedField>(field, 2);
        const auto control = control_samples(smoothed, Filter::Interpolating);
        Random random(2);
        for (int i = 0; i < 50; ++i) {
            const Vec3d p = middle + 9 * test::random_point(random, -1, 1).normalized();
            const Jet jet = tricubic_jet(*control, p);
            const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
            // The Hessian errs by (1/12) of fourth derivatives, at most 15/9^3 of a distance.
            EXPECT_NEAR(c.k1, 1.0 / 9, 15.0 / 12 / 729);
            EXPECT_NEAR(c.k2, 1.0 / 9, 15.0 / 12 / 729);
        }
    }
}

TEST(SmoothedField, CopiesAnyBoxAndLevelAlike) {
    Random random(3);
    const auto noise = std::make_shared<DenseField>(
        test::random_dense(random, {Index3(-8, -8, -8), Index3(9, 11, 10)}));
    const SmoothedField smoothed(noise, 0.7);
    const IndexBox box{Index3(-12, -6, -10), Index3(2, 3, 7)};
    const std::vector<float> values = test::copied(smoothed, box);
    const ValueRange range = smoothed.value_range(box);
    std::size_t i = 0;
    test::for_each_sample(box, [&](const Index3& index) {
        EXPECT_EQ(values[i], sample(smoothed, index));
        EXPECT_GE(values[i], range.min);
        EXPECT_LE(values[i], range.max);
        ++i;
    });
    i = 0;
    const std::vector<float> coarse =
        test::copied(smoothed, {Index3(-3, -2, -1), Index3(1, 2, 3)}, 2);
    test::for_each_sample({Index3(-3, -2, -1), Index3(1, 2, 3)}, [&](const Index3& index) {
        EXPECT_EQ(coarse[i++], sample(smoothed, 4 * index));
    });
}

TEST(SmoothedField, RefusesImpossibleScales) {
    const auto field = sampled_in(GridSpace::uniform(1), [](const Vec3d& p) { return p.x(); });
    for (const double scale : {-1.0, 17.0, std::nan("")})
        EXPECT_THROW(SmoothedField(field, scale), InputError);
}

} // namespace
} // namespace isocast
