// Primitives that are hard to draw: far, huge, thin, cut open, parallel to rays, at one point.
// Pictures against a double ray caster; where nothing else is said, not one pixel differs.
// SPDX-License-Identifier: MPL-2.0
#include "../quadrics/random_primitives.h"
#include "renderer_test_base.h"
#include "splat_judge.h"
#include "stability/splat_scenes.h"
#include "volume/errors.h"

#include <gmock/gmock.h>

namespace isocast::test {
namespace {

struct HardSplat : RendererTest {
    Camera camera{.eye_world = {0, 0, 5}, .target_world = Vec3d::Zero()};
    Random random{7};

    /// Draws, and expects no wrong pixel and hits as exact as said.
    ///
    /// error  of positions, by their distance from the eye: some roundings, of which GLSL allows
    /// five for
    ///        each division, and GPUs need them (1.16e-6 on one)
    Judgement expect_exact(const Primitives& primitives, int width = 320, int height = 240,
                           double error = 1.5e-6) {
        const Judgement judgement = judge(renderer, primitives, camera, width, height);
        EXPECT_EQ(judgement.wrong, 0) << "at " << testing::PrintToString(judgement.pixels);
        EXPECT_LT(judgement.worst_error, error);
        return judgement;
    }
};

TEST_F(HardSplat, SpheresAtThePicturesBordersAndCorners) {
    for (const double fov : {60.0, 90.0, 140.0}) {
        camera.fov_y_degrees = fov;
        expect_exact(spheres_at_borders_and_corners(camera), 1024, 768);
    }
}

TEST_F(HardSplat, SpheresThatOverlap) {
    Primitives spheres;
    for (int i = 0; i < 400; ++i)
        spheres.spheres.push_back(
            {.centre_world = random.in_cube(0.7), .radius_world = random.uniform(0.1, 0.4)});
    expect_exact(spheres, 1024, 768);
}

TEST_F(HardSplat, AcrossTheEyesPlaneAndAroundTheEye) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        const Primitives some = stability::around_the_eye(camera.eye_world);
        expect_exact(some);
        for (std::size_t kind = 0; kind < 5; ++kind) { // each alone: none hides another
            Primitives one;
            if (kind == 0) one.spheres = some.spheres;
            if (kind == 1) one.ellipsoids = some.ellipsoids;
            if (kind == 2) one.cylinders = some.cylinders;
            if (kind == 3) one.cones = some.cones;
            if (kind == 4) one.quadrics = some.quadrics;
            SCOPED_TRACE(kind);
            expect_exact(one);
        }
    }
}

TEST_F(HardSplat, SmallByTheirDistanceAreAsRoundAsNear) {
    for (const double ratio : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
        const double distance = 1 / ratio;
        camera.eye_world = distance * Vec3d(0.3, 0.5, 1).normalized();
        // 2.4 radii from top to bottom.
        camera.fov_y_degrees = 2 * std::atan(1.2 / distance) * 180 / std::acos(-1.0);
        SCOPED_TRACE(ratio);
        for (const auto& [kind, one] : stability::each_kind()) {
            SCOPED_TRACE(kind);
            expect_exact(one, 120, 120);
        }
    }
}

TEST_F(HardSplat, FarFromTheWorldsOrigin) {
    const Vec3d far(1e7, -2e7, 3e7);
    camera.eye_world += far;
    camera.target_world += far;
    Primitives some;
    for (int i = 0; i < 20; ++i) {
        some.spheres.push_back({.centre_world = far + random.in_cube(1), .radius_world = 0.1});
        some.cylinders.push_back({.a_world = far + random.in_cube(1),
                                  .b_world = far + random.in_cube(1),
                                  .radius_world = 0.05});
    }
    expect_exact(some);
}

TEST_F(HardSplat, EllipsoidsAsThinAsAMillionth) {
    Primitives some;
    for (int i = 0; i < 12; ++i)
        some.ellipsoids.push_back(
            {.centre_world = random.in_cube(1),
             .axes_world = random.rotation() * Vec3d(0.5, 0.5, 0.5e-6).asDiagonal()});
    // Rays that graze a disc meet it anywhere within a rounding's angle of theirs.
    expect_exact(some, 320, 240, 1e-4);
}

TEST_F(HardSplat, CylindersAlongTheViewsAxis) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic})
        for (const bool is_capped : {false, true}) {
            camera.projection = projection;
            expect_exact({.cylinders = {{.a_world = {0, 0, -1},
                                         .b_world = {0, 0, 1},
                                         .radius_world = 0.5,
                                         .is_capped = is_capped}}});
        }
}

TEST_F(HardSplat, ConesWhoseSideIsParallelToRays) {
    // A side is parallel to the view's axis, a little below it: a ray within it could meet it
    // anywhere.
    const double tilt = 0.3;
    const Vec3d a(0, -0.05, 3);
    const Vec3d b = a + 4 * Vec3d(0, -std::sin(tilt), -std::cos(tilt));
    for (const bool is_capped : {false, true})
        expect_exact({.cones = {{.a_world = a,
                                 .b_world = b,
                                 .radius_a_world = 0,
                                 .radius_b_world = 4 * std::tan(tilt),
                                 .is_capped = is_capped},
                                {.a_world = {0, 0, -1},
                                 .b_world = {0, 0, 1},
                                 .radius_a_world = 0.6,
                                 .radius_b_world = 0.4,
                                 .is_capped = is_capped}}},
                     321, 241);
}

TEST_F(HardSplat, ParaboloidsAlongParallelRays) {
    // alpha is 0 for every ray.
    camera.projection = Projection::Orthographic;
    for (const double bend : {1.0, -1.0})
        expect_exact({.quadrics = {{.axes_world = Mat3d::Identity() * 0.7,
                                    .a = Vec3d(1, 1, 0).asDiagonal(),
                                    .b = {0, 0, 0.5 * bend},
                                    .c = -0.2},
                                   {.centre_world = {0.2, 0.1, -1},
                                    .a = Vec3d(1, -1, 0).asDiagonal(),
                                    .b = {0, 0, 0.3071 * bend},
                                    .c = 0}}});
}

TEST_F(HardSplat, SphereAsLargeAsTheSceneWithTheEyeJustOutside) {
    for (const double height : {1e-1, 1e-3, 1e-5}) {
        camera.eye_world = {0, 0, 1 + height};
        camera.target_world = {0.5, 0, 1 + 0.9 * height}; // along the surface
        camera.up = Vec3d::UnitZ();
        camera.fov_y_degrees = 60;
        SCOPED_TRACE(height);
        // Hits are as far as the surface's own roundings let grazing rays go: 1e-7 / height.
        expect_exact({.spheres = {{}}}, 320, 240, 1e-5 + 1e-6 / height);
    }
}

TEST_F(HardSplat, BoxAcrossTheEyesPlane) {
    camera.eye_world = {0.2, 0.1, 0.3};
    camera.target_world = {0.2, 0.1, -1};
    expect_exact({.quadrics = {{.axes_world = Vec3d(2, 1, 1).asDiagonal(),
                                .a = Vec3d(1, -1, 0.5).asDiagonal(),
                                .b = {0.1, 0, 0.3},
                                .c = -0.2}}});
}

TEST_F(HardSplat, AllAtOnePoint) {
    Primitives some;
    for (int i = 0; i < 400; ++i) {
        some.spheres.push_back({.radius_world = 0.2 + 1e-4 * i});
        some.cylinders.push_back(
            {.a_world = {0, -0.5, 0}, .b_world = {0, 0.5, 0}, .radius_world = 0.3 + 1e-5 * i});
    }
    expect_exact(some);
    // All the same: any of them.
    for (Sphere& sphere : some.spheres) sphere.radius_world = 0.5;
    renderer.load(
        {.primitives = std::make_shared<Primitives>(Primitives{.spheres = some.spheres})});
    renderer.draw(camera, 100, 100, {FrameImage::Hit});
    const Image many = renderer.read(FrameImage::Hit);
    renderer.load({.primitives = std::make_shared<Primitives>(
                       Primitives{.spheres = {{.radius_world = 0.5}}})});
    renderer.draw(camera, 100, 100, {FrameImage::Hit});
    EXPECT_EQ(renderer.read(FrameImage::Hit).rgba, many.rgba);
}

TEST_F(HardSplat, AMillionSpheres) {
    Primitives spheres;
    for (int i = 0; i < 1'000'000; ++i)
        spheres.spheres.push_back({.centre_world = random.in_cube(1), .radius_world = 0.004});
    const Judgement judgement = judge(renderer, spheres, camera, 256, 256);
    // A pixel is about as large as a sphere: each shows a piece of silhouette, 2^16 of which lie
    // within roundings of 1e-7 of a sphere's size of another.
    EXPECT_LE(judgement.wrong, 5);
    EXPECT_GT(judgement.seen, 20000);
}

TEST_F(HardSplat, FiftyTwoThousandSpheresInABall) {
    Primitives spheres;
    while (spheres.spheres.size() < 52000)
        if (const Vec3d p = random.in_cube(1); p.norm() < 1)
            spheres.spheres.push_back({.centre_world = p, .radius_world = std::sqrt(45.0 / 52000)});
    // Where a ray grazes two spheres at once within roundings, either is right.
    EXPECT_LE(judge(renderer, spheres, camera, 1024, 768).wrong, 5);
}

TEST_F(HardSplat, ThatCannotBeDrawnAreRefusedByTheirIndex) {
    for (const double radius : {0.0, -1.0, double(NAN), double(INFINITY)}) {
        Primitives spheres{.spheres = {{}, {}, {.radius_world = radius}}};
        EXPECT_THAT([&] { renderer.load({.primitives = std::make_shared<Primitives>(spheres)}); },
                    testing::ThrowsMessage<InputError>(testing::HasSubstr("sphere 2: its radius")));
    }
}

} // namespace
} // namespace isocast::test
