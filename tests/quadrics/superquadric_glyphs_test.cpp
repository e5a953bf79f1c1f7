// Superquadrics of tensors, what of them can be drawn, and their bounds on the picture.
// SPDX-License-Identifier: MPL-2.0
#include "superquadric_oracle.h"

namespace isocast {
namespace {

Mat3d tensor_of(const Mat3d& rotation, const Vec3d& eigenvalues) {
    const Mat3d t = rotation * eigenvalues.asDiagonal() * rotation.transpose();
    return (t + t.transpose()) / 2;
}

TEST(SuperquadricOfTensor, ShapesAreThoseOfThePaper) {
    Random random(12);
    const Mat3d r = random.rotation();
    const Vec3d centre(1, 2, 3);
    const auto ball = superquadric_of(centre, tensor_of(r, Vec3d::Constant(2)));
    ASSERT_TRUE(ball);
    EXPECT_NEAR(ball->alpha, 1, 1e-13); // roundings of eigenvalues, times sharpness 3
    EXPECT_NEAR(ball->beta, 1, 1e-13);
    EXPECT_EQ(ball->centre_world, centre);

    const auto linear = superquadric_of(centre, tensor_of(r, Vec3d(0, 2, 0)));
    ASSERT_TRUE(linear);
    EXPECT_NEAR(linear->alpha, 1, 1e-13);
    EXPECT_EQ(linear->beta, 0.05);
    EXPECT_NEAR(std::abs(linear->axes_world.col(2).dot(r.col(1))), 2, 1e-13);
    EXPECT_NEAR(linear->axes_world.col(0).norm(), 0.02, 1e-13);

    const auto planar = superquadric_of(centre, tensor_of(r, Vec3d(2, 0, 2)));
    ASSERT_TRUE(planar);
    EXPECT_NEAR(planar->alpha, 1, 1e-13);
    EXPECT_EQ(planar->beta, 0.05);
    EXPECT_NEAR(std::abs(planar->axes_world.col(2).normalized().dot(r.col(1))), 1, 1e-13);

    // l = 3, 2, 1: c_l = 1/6, c_p = 1/3: planar, alpha = (5/6)^3, beta = (2/3)^3.
    const auto box = superquadric_of(centre, tensor_of(r, Vec3d(1, 3, 2)), {.tensor_scale = 10});
    ASSERT_TRUE(box);
    EXPECT_NEAR(box->alpha, 125.0 / 216, 1e-13);
    EXPECT_NEAR(box->beta, 8.0 / 27, 1e-13);
    EXPECT_NEAR(std::abs(box->axes_world.col(2).dot(r.col(0))), 10, 1e-12);
    EXPECT_NEAR(box->axes_world.determinant(), 6000, 1e-9);

    EXPECT_FALSE(superquadric_of(centre, Mat3d::Zero()));
    EXPECT_FALSE(superquadric_of(centre, Mat3d::Identity() * 1e-31));
}

// Points of the glyph's surface turn with the tensor, and hardly move when it hardly changes: also
// where c_l = c_p and the axis jumps from the first to the third eigenvector.
TEST(SuperquadricOfTensor, GlyphsTurnWithTheTensorAndChangeSteadily) {
    Random random(13);
    for (int k = 0; k < 500; ++k) {
        const Mat3d r = random.rotation(), turn = random.rotation();
        // 5 3 2: c_l = 2/10 = c_p; beside it at random.
        const Vec3d l = k % 2 ? Vec3d(5, 3, 2) : Vec3d(random.in_cube(1).array() + 2);
        const Superquadric s = *superquadric_of(Vec3d::Zero(), tensor_of(r, l));
        const Superquadric turned = *superquadric_of(Vec3d::Zero(), tensor_of(turn * r, l));
        const Superquadric beside =
            *superquadric_of(Vec3d::Zero(), tensor_of(r, l + 1e-9 * random.in_cube(1)));
        for (int i = 0; i < 10; ++i) {
            const Vec3d n = random.unit();
            // Eigenvectors of values 1e-3 apart are 1e-12 exact; closer ones leave rounder shapes.
            EXPECT_NEAR(support(turned, turn * n), support(s, n), 1e-10 * s.axes_world.norm());
            EXPECT_NEAR(support(beside, n), support(s, n), 1e-7 * s.axes_world.norm());
        }
    }
}

TEST(SuperquadricOfTensor, PointsWithTensorsBecomeGlyphs) {
    const PointData points = points_of_bytes("x,y,z,txx,tyy,tzz,txy,txz,tyz,r,g,b\n"
                                             "1,2,3,3,2,1,0,0,0,1,0,0\n4,5,6,0,0,0,0,0,0,1,1,1\n",
                                             "a.csv");
    const PointPrimitives glyphs = primitives_of(points, {.glyph = TensorGlyph::Superquadric});
    EXPECT_TRUE(glyphs.ellipsoids.empty());
    ASSERT_EQ(glyphs.superquadrics.size(), 1U);
    EXPECT_EQ(glyphs.dropped, 1U);
    EXPECT_EQ(glyphs.superquadrics[0].colour, Vec3d(1, 0, 0));
    check(glyphs.superquadrics);
}

TEST(SuperquadricCheck, NamesTheFirstThatCannotBeDrawn) {
    std::vector<Superquadric> two(2);
    check(two);
    const auto error = [&](const Superquadric& bad) {
        two[1] = bad;
        return test::message_of<InputError>([&] { check(two); });
    };
    EXPECT_EQ(error({.axes_world = Mat3d::Ones()}), "superquadric 1: its axes lie in a plane");
    EXPECT_THAT(error({.alpha = 0.04}), HasSubstr("superquadric 1: an exponent is 0.04, not from"));
    EXPECT_THAT(error({.beta = std::nan("")}), HasSubstr("an exponent is nan"));
    EXPECT_THAT(error({.centre_world = Vec3d(0, INFINITY, 0)}), HasSubstr("it is not finite"));
}

// ----------------------------------------------------------------------------------------- bounds

TEST(SuperquadricBounds, SupportsAreReachedAndNotPassed) {
    Random random(14);
    for (int k = 0; k < 300; ++k) {
        const Superquadric s = random_superquadric(random);
        const NormExponents<double> e{2 / s.alpha, 2 / s.beta};
        const Vec3d n = random.unit();
        const double most = support(s, n);
        for (int i = 0; i < 100; ++i) {
            const Vec3d q = random.unit();
            const Vec3d p = s.axes_world * q / superquadric_norm(q, e).value;
            EXPECT_LE(n.dot(p), most * (1 + 16 * eps)); // 4 roundings of each norm, and the product
        }
        const Vec3d touched = s.axes_world.inverse() * (farthest_point(s, n) - s.centre_world);
        EXPECT_NEAR(n.dot(s.axes_world * touched), most, 16 * eps * most);
        // Roundings of the centre, in the least of the semi-axes.
        EXPECT_NEAR(superquadric_norm(touched, e).value, 1,
                    16 * eps * s.axes_world.inverse().norm());
    }
    const Primitives cube{.superquadrics = {{.alpha = 0.05, .beta = 0.05}}};
    EXPECT_EQ(box_of(cube).min(), Vec3d::Constant(-1));
    EXPECT_EQ(box_of(cube).max(), Vec3d::Constant(1));
}

TEST(SuperquadricBounds, RectanglesHoldTheBodyAndTouchIt) {
    Random random(15);
    int rectangles = 0;
    double worst = 0, worst_float = 0;
    for (int k = 0; k < 2000; ++k) {
        const Superquadric s = random_superquadric(random);
        const NormExponents<double> e{2 / s.alpha, 2 / s.beta};
        PictureSpace space{.view_from_world = random.rotation().transpose(),
                           .is_perspective = k % 3 != 0};
        const double distance = random.log_uniform(0.1, k % 2 ? 10 : 1e6);
        space.eye_world =
            s.centre_world + space.view_from_world.transpose() *
                                 Vec3d(random.uniform(-0.5, 0.5) * distance,
                                       random.uniform(-0.5, 0.5) * distance, distance);
        const ScreenBounds bounds = screen_bounds(s, space);
        if (bounds.extent != ScreenExtent::Rectangle) continue;
        ++rectangles;
        for (int i = 0; i < 50; ++i) {
            const Vec3d q = random.unit();
            const Vec3d p = space.view_from_world *
                            (s.centre_world + s.axes_world * q / superquadric_norm(q, e).value -
                             space.eye_world);
            const Eigen::Vector2d at = space.is_perspective ? Eigen::Vector2d(p.head<2>() / -p.z())
                                                            : Eigen::Vector2d(p.head<2>());
            // Roundings of the place, and of the difference from the eye: 1e-14 as stated.
            const double allowed =
                1e-14 * std::max(bounds.lo.cwiseAbs().maxCoeff(), bounds.hi.cwiseAbs().maxCoeff());
            EXPECT_TRUE((at.array() >= bounds.lo.array() - allowed).all());
            EXPECT_TRUE((at.array() <= bounds.hi.array() + allowed).all());
        }
        // The same in float, from the same numbers rounded: each moves the sides by a rounding.
        const ScreenBoundsOf<float> rounded = superquadric_bounds<float>(
            (space.view_from_world * (s.centre_world - space.eye_world)).cast<float>(),
            (space.view_from_world * s.axes_world).cast<float>(), {float(e.p), float(e.r)},
            space.is_perspective);
        if (distance > 2 * s.axes_world.norm()) { // else sides may lie nearly behind the eye
            const double scale =
                std::max(bounds.lo.cwiseAbs().maxCoeff(), bounds.hi.cwiseAbs().maxCoeff());
            worst_float = std::max(
                {worst_float, (rounded.lo.cast<double>() - bounds.lo).cwiseAbs().maxCoeff() / scale,
                 (rounded.hi.cast<double>() - bounds.hi).cwiseAbs().maxCoeff() / scale});
        }
        // Each side touches: the plane through the eye and the side has the body on one side, at 0.
        const Mat3d axes = space.view_from_world * s.axes_world;
        const Vec3d centre = space.view_from_world * (s.centre_world - space.eye_world);
        for (int side = 0; side < 4; ++side) {
            const int axis = side % 2;
            const double sign = side < 2 ? 1 : -1,
                         at = side < 2 ? bounds.hi[axis] : bounds.lo[axis];
            const Vec3d plane = sign * Vec3d(axis == 0, axis == 1, space.is_perspective ? at : 0);
            const double offset = space.is_perspective ? 0 : sign * at;
            const double gap = plane.dot(centre) - offset +
                               superquadric_norm(Vec3d(axes.transpose() * plane), dual(e)).value;
            worst = std::max(worst, std::abs(gap) / (plane.norm() * centre.norm()));
        }
    }
    std::printf("worst gap %.1e of the distance; float %.1e of the farthest side\n", worst,
                worst_float);
    EXPECT_LE(worst, 1e-14);      // as stated
    EXPECT_LE(worst_float, 1e-6); // 8 roundings, of the same numbers
    EXPECT_GT(rectangles, 1500);
}

TEST(SuperquadricBounds, OfBallsAreThoseOfEllipsoids) {
    Random random(16);
    for (int k = 0; k < 500; ++k) {
        Superquadric s = random_superquadric(random);
        s.alpha = s.beta = 1;
        PictureSpace space{.view_from_world = random.rotation().transpose(),
                           .is_perspective = random.coin()};
        space.eye_world = s.centre_world + random.in_cube(random.log_uniform(0.5, 1e3));
        const ScreenBounds found = screen_bounds(s, space);
        const ScreenBounds expected = screen_bounds(
            Ellipsoid{.centre_world = s.centre_world, .axes_world = s.axes_world}, space);
        ASSERT_EQ(found.extent, expected.extent);
        const double scale = std::max(
            {1e-300, expected.lo.cwiseAbs().maxCoeff(), expected.hi.cwiseAbs().maxCoeff()});
        // Bodies that nearly reach the eye's plane have sides as far as the quotient is lost.
        const double allowed = scale < 100 ? 1e-12 * std::max(scale, 1.0) : 1e-9 * scale;
        EXPECT_LE((found.lo - expected.lo).norm(), allowed);
        EXPECT_LE((found.hi - expected.hi).norm(), allowed);
    }
}

} // namespace
} // namespace isocast
