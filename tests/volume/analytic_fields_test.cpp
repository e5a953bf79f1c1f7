// Tests of the analytic fields: derivatives against differences, distances against offset surfaces.
// SPDX-License-Identifier: MPL-2.0
#include "volume/analytic_fields.h"

#include "random_fields.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace isocast {
namespace {

using std::numbers::pi;
using test::Random;

/// Built-in fields, and distances about an oblique axis off the origin.
std::vector<AnalyticField> all_fields() {
    std::vector<AnalyticField> fields;
    for (const std::string& name : builtin_field_names()) fields.push_back(builtin_field(name));
    fields.push_back(torus_field({0.1, -0.2, 0.3}, {1, 2, -2}, 0.8, 0.3));
    fields.push_back(cylinder_field({0.3, 0.1, -0.2}, {-1, 1, 3}, 0.4));
    return fields;
}

/// Central differences, extrapolated once, and a bound of their error.
struct Difference {
    double value;
    double error;
};

/// The derivative of g at 0. The error of the extrapolated difference is about h^4; that of step
/// h/2 is then a fifteenth of how far the two differ, which we take whole, plus the rounding of
/// values of the given size.
template<class G>
Difference derivative(G g, double h, double size) {
    const auto central = [&](double s) { return (g(s) - g(-s)) / (2 * s); };
    const auto extrapolated = [&](double s) { return (4 * central(s / 2) - central(s)) / 3; };
    const double fine = extrapolated(h / 2);
    const double rounding = 32 * std::numeric_limits<double>::epsilon() * size / h;
    return {fine, std::abs(fine - extrapolated(h)) + rounding};
}

TEST(AnalyticFields, DerivativesEqualExtrapolatedDifferences) {
    Random random(1);
    for (const AnalyticField& field : all_fields()) {
        int tried = 0;
        for (int i = 0; i < 300; ++i) {
            const Vec3d p =
                test::random_point(random, -field.half_extent_world, field.half_extent_world);
            const Jet jet = field.jet(p);
            // Distances have no derivatives at centres and axes; 1/0.05 is the curvature near them.
            const bool is_distance =
                field.name == "sphere" || field.name == "torus" || field.name == "cylinder";
            if (is_distance && jet.hessian.norm() > 20) continue;
            ++tried;
            const double h = 1e-3; // a fortieth of the nearest pole, a hundredth of a ripple
            // An ulp of Marschner-Lobb's phase, up to 12 pi, moves the gradient by that much of the
            // Hessian over 6 pi^2: hence the Hessian among the sizes.
            const double gradient_size = 1 + jet.gradient.norm() + jet.hessian.norm();
            for (int k = 0; k < 3; ++k) {
                const Difference slope =
                    derivative([&](double s) { return field.jet(p + s * Vec3d::Unit(k)).value; }, h,
                               1 + std::abs(jet.value));
                EXPECT_NEAR(jet.gradient[k], slope.value, slope.error) << field.name;
                // The bound must be tight enough to find a wrong digit.
                EXPECT_LT(slope.error, 1e-5 * gradient_size) << field.name;
                for (int l = 0; l < 3; ++l) {
                    const Difference bend = derivative(
                        [&](double s) { return field.jet(p + s * Vec3d::Unit(k)).gradient[l]; }, h,
                        gradient_size);
                    EXPECT_NEAR(jet.hessian(k, l), bend.value, bend.error) << field.name;
                    EXPECT_LT(bend.error, 1e-5 * (1 + jet.hessian.norm())) << field.name;
                }
            }
            // Symmetric up to the order of products: an ulp or two.
            EXPECT_LT((jet.hessian - jet.hessian.transpose()).norm(), 1e-15 * jet.hessian.norm())
                << field.name;
        }
        EXPECT_GT(tried, 200) << field.name;
    }
}

TEST(AnalyticFields, DistancesHaveUnitGradientsAndNoBendAlongThem) {
    Random random(2);
    for (const AnalyticField& field : all_fields()) {
        if (field.name != "sphere" && field.name != "torus" && field.name != "cylinder") continue;
        for (int i = 0; i < 1000; ++i) {
            const Jet jet = field.jet(test::random_point(random, -2, 2));
            // An identity: some ulps, and 1/r times as many in the second derivatives.
            EXPECT_NEAR(jet.gradient.norm(), 1, 1e-14);
            EXPECT_LT((jet.hessian * jet.gradient).norm(), 1e-14 * (1 + jet.hessian.norm()));
        }
    }
}

TEST(AnalyticFields, TorusHasTheDistanceOfItsOffsetSurfaces) {
    Random random(3);
    const Vec3d centre(0.1, -0.2, 0.3);
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), Vec3d(1, 2, -2));
    const AnalyticField field = torus_field(centre, {1, 2, -2}, 0.8, 0.3);
    for (int i = 0; i < 1000; ++i) {
        const double u = test::random_real(random, 0, 2 * pi);
        const double v = test::random_real(random, 0, 2 * pi);
        const double d = test::random_real(random, -0.3, 0.5); // up to the axis
        const double rho = 0.8 + (0.3 + d) * std::cos(v);
        const Vec3d p(rho * std::cos(u), rho * std::sin(u), (0.3 + d) * std::sin(v));
        EXPECT_NEAR(field.jet(centre + turn * p).value, d, 1e-15 * 8); // ulps of coordinates near 2
    }
}

TEST(AnalyticFields, CylinderHasTheDistanceOfItsOffsetSurfaces) {
    Random random(4);
    const Vec3d point(0.3, 0.1, -0.2);
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), Vec3d(-1, 1, 3));
    const AnalyticField field = cylinder_field(point, {-1, 1, 3}, 0.4);
    for (int i = 0; i < 1000; ++i) {
        const double u = test::random_real(random, 0, 2 * pi);
        const double rho = test::random_real(random, 0, 2);
        const Vec3d p(rho * std::cos(u), rho * std::sin(u), test::random_real(random, -2, 2));
        EXPECT_NEAR(field.jet(point + turn * p).value, rho - 0.4, 1e-15 * 8); // ulps near 2
    }
}

TEST(AnalyticFields, AreFiniteAtTheirSingularPoints) {
    const Jet centre = builtin_field("sphere").jet(Vec3d::Zero());
    EXPECT_EQ(centre.value, -1);
    EXPECT_EQ(centre.gradient, Vec3d::Zero());
    EXPECT_EQ(centre.hessian, Mat3d::Zero());
    EXPECT_EQ(builtin_field("cylinder").jet({0, 0, 0.3}).value, -0.5);
    EXPECT_EQ(builtin_field("cylinder").jet({0, 0, 0.3}).gradient, Vec3d::Zero());
    EXPECT_EQ(builtin_field("torus").jet({1, 0, 0}).value, -0.4);
    EXPECT_EQ(builtin_field("torus").jet({1, 0, 0}).gradient, Vec3d::Zero());
    EXPECT_EQ(builtin_field("torus").jet({0, 0, 0}).value, 1 - 0.4);
    const Jet ripple = builtin_field("marschner-lobb").jet(Vec3d::Zero());
    EXPECT_TRUE(ripple.hessian.allFinite());
    EXPECT_EQ(ripple.gradient.head<2>(), Eigen::Vector2d::Zero());
}

TEST(AnalyticFields, MarschnerLobbIsTheirFormulaLessOneHalf) {
    const AnalyticField field = builtin_field("marschner-lobb");
    Random random(5);
    for (int i = 0; i < 100; ++i) {
        const Vec3d p = test::random_point(random, -1, 1);
        const double rho = std::cos(12 * pi * std::cos(pi * std::hypot(p.x(), p.y()) / 2));
        const double value = (1 - std::sin(pi * p.z() / 2) + 0.25 * (1 + rho)) / (2 * 1.25);
        EXPECT_NEAR(field.jet(p).value, value - 0.5, 1e-14); // 12 pi amplifies an ulp of the cosine
    }
    EXPECT_LT(field.jet({0, 0, 1}).value, 0); // inside at large z
}

TEST(AnalyticFields, SaddleHasUnitCurvaturesAtTheOrigin) {
    const Jet jet = builtin_field("saddle").jet(Vec3d::Zero());
    EXPECT_EQ(jet.gradient, Vec3d::UnitZ());
    EXPECT_EQ(jet.hessian.topLeftCorner(2, 2).determinant(), -1);
    EXPECT_EQ(jet.hessian.trace(), 0);
}

TEST(AnalyticFields, BuiltinNamesAreListedForAnUnknownOne) {
    try {
        builtin_field("spere");
        FAIL();
    } catch (const InputError& error) {
        for (const std::string& name : builtin_field_names()) {
            EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
        }
    }
}

TEST(AnalyticFields, InsideIsNegativeAndTheCubesFacesAreOutsideOfClosedShapes) {
    for (const std::string name : {"sphere", "torus", "cube"}) {
        const auto field = sampled(builtin_field(name), 24);
        EXPECT_LT(field->value_range(field->extent()).min, 0) << name;
        for (int axis = 0; axis < 3; ++axis) {
            IndexBox face = field->extent();
            face.hi[axis] = face.lo[axis] + 1;
            EXPECT_GT(field->value_range(face).min, 0) << name;
        }
    }
}

TEST(SampledField, SamplesSpanTheCube) {
    const AnalyticField torus = builtin_field("torus");
    const auto field = sampled(torus, 33);
    EXPECT_EQ(field->extent(), (IndexBox{Index3::Zero(), Index3::Constant(33)}));
    EXPECT_EQ(field->space().to_world(Vec3d::Zero()), Vec3d::Constant(-1.75));
    EXPECT_LT((field->space().to_world(Vec3d::Constant(32)) - Vec3d::Constant(1.75)).norm(), 1e-15);
    EXPECT_EQ(field->half_width_world(), std::nullopt);
    test::for_each_sample({Index3::Constant(3), Index3::Constant(9)}, [&](const Index3& at) {
        const double exact = torus.jet(field->space().to_world(at.cast<double>())).value;
        EXPECT_EQ(sample(*field, at), static_cast<float>(exact));
    });
}

TEST(SampledField, CopiesWhatADenseFieldOfItsSamplesCopies) {
    Random random(6);
    const auto field = sampled(builtin_field("gyroid"), 20);
    const DenseField dense(field->space(), field->extent(), test::copied(*field, field->extent()));
    for (int i = 0; i < 100; ++i) {
        const IndexBox box = test::random_box(random, -8, 20, 9);
        const int level = test::random_int(random, 0, 2);
        EXPECT_EQ(test::copied(*field, box, level), test::copied(dense, box, level));
        EXPECT_EQ(field->value_range(box).min, dense.value_range(box).min);
        EXPECT_EQ(field->value_range(box).max, dense.value_range(box).max);
    }
}

TEST(SampledField, BandClampsItsValuesAndIsOutsideBeyondTheCube) {
    const auto plain = sampled(builtin_field("cylinder"), 17);
    const auto band = sampled(builtin_field("cylinder"), 17, 2.0);
    const auto half_width = static_cast<float>(2 * band->space().voxel_size_world());
    EXPECT_EQ(static_cast<float>(*band->half_width_world()), half_width);
    test::for_each_sample(dilated(band->extent(), 2, 2), [&](const Index3& at) {
        const float expected = band->extent().contains(at)
                                   ? std::clamp(sample(*plain, at), -half_width, half_width)
                                   : half_width;
        EXPECT_EQ(sample(*band, at), expected);
    });
}

TEST(SampledField, RefusesTooFewOrTooManySamples) {
    EXPECT_THROW(sampled(builtin_field("sphere"), 3), InputError);
    EXPECT_THROW(sampled(builtin_field("sphere"), 4097), InputError);
}

} // namespace
} // namespace isocast
