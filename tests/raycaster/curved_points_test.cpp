// Points over isosurfaces: on them, evenly, with the curvatures of known shapes.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/curved_points.h"

#include "filtering/filter.h"
#include "filtering/reconstruct.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"
#include "volume/placed_field.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isocast {
namespace {

double closest_pair(const std::vector<CurvedPoint>& points) {
    double least = INFINITY;
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            least = std::min(least, (points[i].position_world - points[j].position_world).norm());
    return least;
}

TEST(CurvedPoints, OfATorusHaveItsCurvatures) {
    // Where the surface is about `iso` from radius 0.4.
    for (const double iso : {0.0, 0.1}) {
        const FieldObject torus{.field = sampled(builtin_field("torus"), 96), .iso_world = iso};
        const CurvedPoints curved = curved_points(torus, 700, 3, 0);
        const double minor = 0.4 + iso;
        ASSERT_EQ(curved.points.size(), 700U);
        EXPECT_EQ(curved.lost, 0U);
        const double area = 4 * std::numbers::pi * std::numbers::pi * minor;
        EXPECT_NEAR(curved.spacing_world, std::sqrt(2 * area / (std::sqrt(3) * 700)), 0.02);
        // scatter()'s 0.65, less what two points move towards each other: a twentieth.
        EXPECT_GT(closest_pair(curved.points), 0.6 * curved.spacing_world);
        for (const CurvedPoint& point : curved.points) {
            const Vec3d& p = point.position_world;
            const double rho = p.head<2>().norm();
            const Vec3d out_of_axis = Vec3d(p.x(), p.y(), 0) / rho;
            const Vec3d normal = (p - out_of_axis).normalized();
            // A voxel is 0.037: of the minor radius a tenth, whose fourth power is 1e-4, and as
            // much of 1e-4 voxels. Curvatures lose two orders.
            EXPECT_NEAR((p - out_of_axis).norm(), minor, 1e-4);
            EXPECT_LT((point.normal - normal).norm(), 1e-3);
            EXPECT_NEAR(point.k1, 1 / minor, 0.02 / minor);
            EXPECT_NEAR(point.k2, normal.dot(out_of_axis) / rho, 0.02 / minor);
            const Vec3d round_the_tube = Vec3d(-p.y(), p.x(), 0).normalized().cross(normal);
            if (point.k1 - point.k2 > 1) {
                EXPECT_GT(std::abs(point.direction1.dot(round_the_tube)), std::cos(0.05));
            }
        }
    }
}

TEST(CurvedPoints, LieOnTheSplineOfEachFilter) {
    for (const Filter filter : {Filter::BSpline, Filter::Interpolating, Filter::Exact,
                                Filter::CatmullRom, Filter::Linear}) {
        const FieldObject object{.field = sampled(builtin_field("cube"), 24), .filter = filter};
        const auto control = control_samples(object.field, filter);
        const CurvedPoints curved = curved_points(object, 300, 1, 0);
        EXPECT_LE(curved.lost, 3U); // of the isolated zero at the origin
        for (const CurvedPoint& point : curved.points) {
            const Jet jet = kernel_jet(*control, control->space().to_index(point.position_world),
                                       kernel_of(filter));
            // [world / voxel]: 1e-4 voxels, and as much for the turn of the gradient.
            EXPECT_LE(std::abs(jet.value), 2e-4 * jet.gradient.norm()) << filter_name(filter);
        }
    }
}

TEST(CurvedPoints, MoveWithTheFieldAndItsPlacement) {
    const std::shared_ptr<const FieldSource> field = sampled(builtin_field("torus"), 48);
    const Placement placement{
        .scale = 3, .rotation_degrees = {10, 20, 30}, .translation_world = {1, 2, 3}};
    const CurvedPoints plain = curved_points({.field = field}, 200, 1, 2);
    const CurvedPoints placed =
        curved_points({.field = std::make_shared<PlacedField>(field, placement)}, 200, 1, 2);
    ASSERT_EQ(plain.points.size(), placed.points.size());
    const Eigen::Affine3d to_world = placement.to_world();
    for (std::size_t i = 0; i < plain.points.size(); ++i) {
        const CurvedPoint& a = plain.points[i];
        const CurvedPoint& b = placed.points[i];
        // Roundings of float samples, and where Newton's steps end: 1e-4 voxels.
        EXPECT_LT((b.position_world - to_world * a.position_world).norm(), 1e-4);
        EXPECT_LT((b.normal - to_world.linear() * a.normal / 3).norm(), 1e-4);
        EXPECT_NEAR(b.k1, a.k1 / 3, 1e-3);
        EXPECT_NEAR(b.k2, a.k2 / 3, 1e-3);
    }
    EXPECT_NEAR(placed.spacing_world, 3 * plain.spacing_world, 1e-4);
}

// Noise of a tenth of a voxel bends the surface by any amount; a Gaussian takes it away.
TEST(CurvedPoints, AtAScaleAreThoseOfTheSmoothedField) {
    const AnalyticField bumpy{"bumpy sphere",
                              [](const Vec3d& p) {
                                  const double noise = std::sin(150 * p.x()) *
                                                       std::sin(150 * p.y()) *
                                                       std::sin(150 * p.z());
                                  return Jet{.value = p.norm() - 0.7 + 0.003 * noise};
                              },
                              1};
    const FieldObject object{.field = sampled(bumpy, 64)};
    const auto worst = [](const CurvedPoints& curved) {
        double off = 0;
        for (const CurvedPoint& point : curved.points)
            off = std::max({off, std::abs(point.k1 - 1 / 0.7), std::abs(point.k2 - 1 / 0.7)});
        return off;
    };
    EXPECT_GT(worst(curved_points(object, 200, 1, 0)), 3);
    EXPECT_LT(worst(curved_points(object, 200, 1, 3)), 0.2);
}

TEST(CurvedPoints, WithoutASurfaceAreAnError) {
    EXPECT_THROW(
        curved_points({.field = sampled(builtin_field("sphere"), 16), .iso_world = 9}, 10, 1, 0),
        InputError);
}

} // namespace
} // namespace isocast
