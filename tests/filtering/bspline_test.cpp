// Tests of the kernels' weights: identities in exact polynomials.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/bspline.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>

namespace isocast {
namespace {

// Weights are at most 1 and each a few operations, so that sums err by some 1e-16; samples of
// x^2 and x^3 reach 8.
constexpr double tolerance = 1e-14;

/// Calls check(a) for a from 0 to 1.
template<class Check>
void for_each_fraction(Check check) {
    for (int i = 0; i <= 100; ++i) check(i / 100.0);
}

/// The sum of weights times power(x) over the four samples x = -1, 0, 1, 2.
double moment(const std::array<double, 4>& weights, int power) {
    double sum = 0;
    for (int i = 0; i < 4; ++i)
        sum += weights[static_cast<std::size_t>(i)] * std::pow(i - 1, power);
    return sum;
}

TEST(Bspline, WeightsAreNotNegative) {
    for_each_fraction([](double a) {
        for (const double weight : bspline_weights(a)) EXPECT_GE(weight, 0) << a;
    });
}

TEST(Bspline, ReproducesLinearsAndShiftsQuadraticsByOneThird) {
    for_each_fraction([](double a) {
        EXPECT_NEAR(moment(bspline_weights(a), 0), 1, tolerance);
        EXPECT_NEAR(moment(bspline_weights(a), 1), a, tolerance);
        EXPECT_NEAR(moment(bspline_weights(a), 2), a * a + 1.0 / 3, tolerance);
        EXPECT_NEAR(moment(bspline_weights(a), 3), a * a * a + a, tolerance);
    });
}

TEST(Bspline, DerivativeWeightsDifferentiateTheSameMoments) {
    for_each_fraction([](double a) {
        EXPECT_NEAR(moment(bspline_weights_d1(a), 0), 0, tolerance);
        EXPECT_NEAR(moment(bspline_weights_d1(a), 1), 1, tolerance);
        EXPECT_NEAR(moment(bspline_weights_d1(a), 2), 2 * a, tolerance);
        EXPECT_NEAR(moment(bspline_weights_d1(a), 3), 3 * a * a + 1, tolerance);
        EXPECT_NEAR(moment(bspline_weights_d2(a), 0), 0, tolerance);
        EXPECT_NEAR(moment(bspline_weights_d2(a), 1), 0, tolerance);
        EXPECT_NEAR(moment(bspline_weights_d2(a), 2), 2, tolerance);
        EXPECT_NEAR(moment(bspline_weights_d2(a), 3), 6 * a, tolerance);
    });
}

TEST(Bspline, DerivativesEqualDifferencesOfTheWeights) {
    // A cubic's central difference errs by its third derivative times h^2/6, and that derivative is
    // -1, 3, -3 and 1; a quadratic's not at all. Rounding: 1e-16/h.
    const double h = 1e-3;
    const std::array<double, 4> third{-1, 3, -3, 1};
    for (int i = 1; i < 100; ++i) {
        const double a = i / 100.0;
        for (std::size_t k = 0; k < 4; ++k) {
            const double d1 = (bspline_weights(a + h)[k] - bspline_weights(a - h)[k]) / (2 * h);
            EXPECT_NEAR(bspline_weights_d1(a)[k], d1 - third[k] * h * h / 6, 1e-12);
            const double d2 =
                (bspline_weights_d1(a + h)[k] - bspline_weights_d1(a - h)[k]) / (2 * h);
            EXPECT_NEAR(bspline_weights_d2(a)[k], d2, 1e-12);
        }
    }
}

TEST(Bspline, JoinsTheNextCellWithTwoContinuousDerivatives) {
    // The weights at a = 1 are those of the next cell at a = 0, one sample on.
    for (const auto weights : {bspline_weights, bspline_weights_d1, bspline_weights_d2}) {
        EXPECT_EQ(weights(1)[0], 0);
        EXPECT_EQ(weights(0)[3], 0);
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_NEAR(weights(1)[k + 1], weights(0)[k], tolerance);
        }
    }
}

TEST(Kernels, OfTheBsplineAreItsWeights) {
    for_each_fraction([](double a) {
        EXPECT_EQ(kernel_weights(Kernel::BSpline, a), bspline_weights(a));
        EXPECT_EQ(kernel_weights_d1(Kernel::BSpline, a), bspline_weights_d1(a));
        EXPECT_EQ(kernel_weights_d2(Kernel::BSpline, a), bspline_weights_d2(a));
    });
}

TEST(Kernels, LinearReproducesLinearsAndCatmullRomQuadratics) {
    for_each_fraction([](double a) {
        for (const Kernel kernel : {Kernel::Linear, Kernel::CatmullRom}) {
            const int degree = kernel == Kernel::Linear ? 1 : 2;
            for (int k = 0; k <= degree; ++k) {
                const auto w = kernel_weights(kernel, a);
                const auto d1 = kernel_weights_d1(kernel, a);
                const auto d2 = kernel_weights_d2(kernel, a);
                EXPECT_NEAR(moment(w, k), std::pow(a, k), tolerance);
                EXPECT_NEAR(moment(d1, k), k == 0 ? 0 : k * std::pow(a, k - 1), tolerance);
                EXPECT_NEAR(moment(d2, k), k == 2 ? 2 : 0, tolerance);
            }
        }
    });
}

TEST(Kernels, LinearAndCatmullRomPassThroughTheSamples) {
    for (const Kernel kernel : {Kernel::Linear, Kernel::CatmullRom}) {
        EXPECT_EQ(kernel_weights(kernel, 0), (std::array<double, 4>{0, 1, 0, 0}));
        EXPECT_EQ(kernel_weights(kernel, 1), (std::array<double, 4>{0, 0, 1, 0}));
    }
}

TEST(Kernels, CatmullRomHasTheSlopeOfTheNeighboursAtTheSamples) {
    EXPECT_EQ(kernel_weights_d1(Kernel::CatmullRom, 0), (std::array<double, 4>{-0.5, 0, 0.5, 0}));
    EXPECT_EQ(kernel_weights_d1(Kernel::CatmullRom, 1), (std::array<double, 4>{0, -0.5, 0, 0.5}));
}

TEST(Kernels, DerivativesEqualDifferencesOfTheWeights) {
    // As for the B-spline; the third derivatives of Catmull-Rom's weights are -3, 9, -9 and 3, and
    // linear weights have none.
    const double h = 1e-3;
    for (const Kernel kernel : {Kernel::Linear, Kernel::CatmullRom}) {
        const std::array<double, 4> third = kernel == Kernel::Linear
                                                ? std::array<double, 4>{}
                                                : std::array<double, 4>{-3, 9, -9, 3};
        for (int i = 1; i < 100; ++i) {
            const double a = i / 100.0;
            for (std::size_t k = 0; k < 4; ++k) {
                const auto difference = [&](auto weights) {
                    return (weights(kernel, a + h)[k] - weights(kernel, a - h)[k]) / (2 * h);
                };
                EXPECT_NEAR(kernel_weights_d1(kernel, a)[k],
                            difference(kernel_weights) - third[k] * h * h / 6, 1e-12);
                EXPECT_NEAR(kernel_weights_d2(kernel, a)[k], difference(kernel_weights_d1), 1e-12);
            }
        }
    }
}

} // namespace
} // namespace isocast
