// Tests of the tricubic reconstruction: polynomials, differences, convergence, convex hull.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/reconstruct.h"

#include "volume/dense_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace isocast {
namespace {

using Random = std::mt19937;

Vec3d random_point(Random& random, double lo, double hi) {
    std::uniform_real_distribution<double> real(lo, hi);
    const double x = real(random);
    const double y = real(random);
    return {x, y, real(random)};
}

/// Samples of value(index) in [-4, 12)^3.
template<class Value>
DenseField field_of(Value value) {
    const IndexBox extent{Index3::Constant(-4), Index3::Constant(12)};
    std::vector<float> values;
    for (int z = -4; z < 12; ++z) {
        for (int y = -4; y < 12; ++y) {
            for (int x = -4; x < 12; ++x) values.push_back(static_cast<float>(value(x, y, z)));
        }
    }
    return {GridSpace::uniform(1), extent, values};
}

DenseField noise(Random& random) {
    std::uniform_real_distribution<double> real(-1, 1);
    return field_of([&](int, int, int) { return real(random); });
}

TEST(Tricubic, ReproducesTrilinearPolynomials) {
    // Integer coefficients and samples: exact in float. Values reach 3000, rounding in double.
    const auto f = [](double x, double y, double z) {
        return 3 - 2 * x + 5 * y + z + x * y - 2 * y * z + 3 * x * z + 2 * x * y * z;
    };
    const DenseField field = field_of(f);
    Random random(1);
    for (int i = 0; i < 200; ++i) {
        const Vec3d p = random_point(random, -2, 9);
        const double x = p.x();
        const double y = p.y();
        const double z = p.z();
        const Jet jet = tricubic_jet(field, p);
        EXPECT_NEAR(jet.value, f(x, y, z), 1e-11);
        const Vec3d gradient(-2 + y + 3 * z + 2 * y * z, 5 + x - 2 * z + 2 * x * z,
                             1 - 2 * y + 3 * x + 2 * x * y);
        EXPECT_LT((jet.gradient - gradient).norm(), 1e-11);
        Mat3d hessian;
        hessian << 0, 1 + 2 * z, 3 + 2 * y, 1 + 2 * z, 0, -2 + 2 * x, 3 + 2 * y, -2 + 2 * x, 0;
        EXPECT_LT((jet.hessian - hessian).norm(), 1e-11);
    }
}

TEST(Tricubic, ShiftsQuadraticsByOneThirdAndKeepsTheirDerivatives) {
    const DenseField field =
        field_of([](int x, int y, int z) { return x * x - 2 * y * y + 4 * z * z; });
    Random random(2);
    for (int i = 0; i < 200; ++i) {
        const Vec3d p = random_point(random, -2, 9);
        const Jet jet = tricubic_jet(field, p);
        const Vec3d a(1, -2, 4);
        // Values reach 600: rounding in double.
        EXPECT_NEAR(jet.value, a.dot(p.cwiseProduct(p)) + a.sum() / 3, 1e-11);
        EXPECT_LT((jet.gradient - 2 * a.cwiseProduct(p)).norm(), 1e-11);
        EXPECT_LT((jet.hessian - (2 * a).asDiagonal().toDenseMatrix()).norm(), 1e-11);
    }
}

TEST(Tricubic, DerivativesEqualDifferencesWithinACell) {
    Random random(3);
    const DenseField field = noise(random);
    const double h = 1e-3;
    for (int i = 0; i < 200; ++i) {
        // Within a cell the function is a cubic along each axis: differences extrapolated once are
        // exact, up to rounding of values near 1 over h.
        const Vec3d p =
            Vec3d(random_point(random, -2, 8).array().floor()) + random_point(random, h, 1 - h);
        const auto derivative = [&](const auto& g, int k) {
            const auto central = [&](double s) {
                const Vec3d step = s * Vec3d::Unit(k);
                return (g(p + step) - g(p - step)) / (2 * s);
            };
            return (4 * central(h / 2) - central(h)) / 3;
        };
        const Jet jet = tricubic_jet(field, p);
        EXPECT_EQ(jet.value, tricubic_value(field, p));
        EXPECT_EQ(jet.hessian, jet.hessian.transpose());
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(jet.gradient[k],
                        derivative([&](const Vec3d& q) { return tricubic_value(field, q); }, k),
                        1e-11);
            for (int l = 0; l < 3; ++l) {
                const auto slope = [&](const Vec3d& q) {
                    return tricubic_jet(field, q).gradient[l];
                };
                EXPECT_NEAR(jet.hessian(k, l), derivative(slope, k), 1e-11);
            }
        }
    }
}

TEST(Tricubic, IsContinuousWithItsDerivativesAcrossCells) {
    Random random(4);
    const DenseField field = noise(random);
    for (int i = 0; i < 200; ++i) {
        Vec3d p = random_point(random, -2, 9);
        const int axis = i % 3;
        p[axis] = std::floor(p[axis]);
        // 1e-12 of a voxel below the face, the jet differs by that times derivatives up to 10.
        const Jet above = tricubic_jet(field, p);
        const Jet below = tricubic_jet(field, p - 1e-12 * Vec3d::Unit(axis));
        EXPECT_NEAR(above.value, below.value, 1e-11);
        EXPECT_LT((above.gradient - below.gradient).norm(), 1e-11);
        EXPECT_LT((above.hessian - below.hessian).norm(), 1e-10);
    }
}

TEST(Tricubic, LiesInTheConvexHullOfItsControlSamples) {
    Random random(5);
    const DenseField field = noise(random);
    for (int i = 0; i < 500; ++i) {
        const Vec3d p = random_point(random, -6, 13); // also where samples are clamped
        const Index3 lo = (p.array().floor().cast<int>() - 1).matrix();
        std::array<float, 64> samples;
        field.copy_box({lo, (lo.array() + 4).matrix()}, 0, samples);
        const auto [min, max] = std::ranges::minmax(samples);
        const double value = tricubic_value(field, p);
        // 1e-15: the weights of 64 samples below 1 sum to 1 but for rounding.
        EXPECT_GE(value, min - 1e-15);
        EXPECT_LE(value, max + 1e-15);
    }
}

TEST(Tricubic, ConvergesAtSecondOrderInValueGradientAndHessian) {
    const AnalyticField gyroid = builtin_field("gyroid");
    // Errors in world units, in the root mean square over the same points.
    const auto errors = [&](int samples_per_axis) {
        const auto field = sampled(gyroid, samples_per_axis);
        const GridSpace& space = field->space();
        Eigen::Array3d sum = Eigen::Array3d::Zero();
        Random random(6);
        for (int i = 0; i < 2000; ++i) {
            const Vec3d p_world = random_point(random, -0.8, 0.8); // clear of the border
            const Jet exact = gyroid.jet(p_world);
            const Jet jet = tricubic_jet(*field, space.to_index(p_world));
            sum[0] += std::pow(jet.value - exact.value, 2);
            sum[1] += (space.gradient_to_world(jet.gradient) - exact.gradient).squaredNorm();
            sum[2] += (space.hessian_to_world(jet.hessian) - exact.hessian).squaredNorm();
        }
        return Eigen::Array3d((sum / 2000).sqrt());
    };
    const Eigen::Array3d coarse = errors(65);
    const Eigen::Array3d fine = errors(129);
    for (int order = 0; order < 3; ++order) {
        // The next term of the error is of fourth order: it bends the slope by (k h)^2/5, k = 2 pi,
        // h = 1/32, less than 0.01. Samples round to 1e-8: in the Hessian, times 4/h^2, 2e-4
        // against an error of 0.03.
        EXPECT_NEAR(std::log2(coarse[order] / fine[order]), 2, 0.05) << order;
    }
}

TEST(Tricubic, SmoothsByASixthOfTheSecondDifferences) {
    // To second order the spline is f + h^2/6 times the Laplacian of f, and the gyroid is an
    // eigenfunction of that, with eigenvalue -2 k^2.
    const AnalyticField gyroid = builtin_field("gyroid");
    const auto field = sampled(gyroid, 129);
    const double kh = 2 * 3.14159265358979 * field->space().voxel_size_world();
    Random random(7);
    for (int i = 0; i < 500; ++i) {
        const Vec3d p_world = random_point(random, -0.8, 0.8);
        const double f = gyroid.jet(p_world).value;
        const double smoothed = f * (1 - 2 * kh * kh / 6);
        // Next term: (kh)^4 times at most 1/10 of the greatest value, 0.24; samples round to 2e-8.
        EXPECT_NEAR(tricubic_value(*field, field->space().to_index(p_world)), smoothed,
                    0.024 * std::pow(kh, 4) + 2e-8);
    }
}

} // namespace
} // namespace isocast
