// Dots: spheres of constant size on the picture, for whoever looks at the scene.
// SPDX-License-Identifier: MPL-2.0
#include "../quadrics/random_primitives.h"
#include "quadrics/splats.h"
#include "renderer_test_base.h"
#include "splat_judge.h"

namespace isocast::test {
namespace {

TEST(Dot, HasAnImageWhoseLesserSemiAxisIsSoManyPixels) {
    Random random(1);
    for (int k = 0; k < 500; ++k) {
        const PictureSpace space{.eye_world = random.in_cube(1),
                                 .view_from_world = random.rotation().transpose(),
                                 .is_perspective = k % 4 != 0};
        const double pixels = random.log_uniform(1, 1e4); // a unit, or a slope of 1
        const double depth = random.log_uniform(1e-3, 1e3);
        const Vec3d centre_view(random.uniform(-1.5, 1.5) * depth, 0, -depth);
        const Dot dot{.centre_world =
                          space.eye_world + space.view_from_world.transpose() * centre_view,
                      .radius_pixels = random.log_uniform(0.1, 0.2 * pixels)};
        const Primitives drawn = with_dots_as_spheres({.dots = {dot}}, space, pixels);
        ASSERT_EQ(drawn.spheres.size(), 1U);
        EXPECT_TRUE(drawn.dots.empty());
        // The ellipse's axes lie towards the middle of the picture, here along x, and across.
        const ScreenBounds bounds = screen_bounds(drawn.spheres[0], space);
        ASSERT_EQ(bounds.extent, ScreenExtent::Rectangle);
        // screen_bounds() errs by some roundings of the place in the picture.
        EXPECT_NEAR((bounds.hi.y() - bounds.lo.y()) / 2 * pixels, dot.radius_pixels,
                    1e-12 * pixels);
        EXPECT_GE((bounds.hi.x() - bounds.lo.x()) / 2 * pixels, dot.radius_pixels - 1e-12 * pixels);
    }
}

struct Dots : RendererTest {
    Camera camera{.eye_world = {0, 0, 5}, .target_world = Vec3d::Zero()};
    Random random{3};

    std::vector<Dot> some(int count) {
        std::vector<Dot> dots;
        for (int i = 0; i < count; ++i)
            dots.push_back({.centre_world = random.in_cube(1),
                            .radius_pixels = random.uniform(2, 9),
                            .colour = colour_of_number(i)});
        return dots;
    }
};

TEST_F(Dots, AreWhatRaysMeetFromNearAndFarAndBetweenOthers) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic})
        for (const double distance : {1.0, 5.0, 500.0}) {
            camera.projection = projection;
            camera.eye_world = distance * Vec3d(0.1, 0.2, 1);
            Primitives primitives{.spheres = {{.radius_world = 0.3}}, .dots = some(30)};
            primitives.cones = {{.radius_a_world = 0.2}};
            const Primitives spheres = with_dots_as_spheres(primitives, picture_space(camera),
                                                            pixels_per_unit(camera, 120));
            // They take the numbers after the spheres'.
            for (std::size_t i = 0; i < 30; ++i)
                primitives.dots[i].colour = colour_of_number(static_cast<int>(i) + 1);
            primitives.spheres[0].colour = colour_of_number(0);
            primitives.cones[0].colour = colour_of_number(31);
            renderer.load({.primitives = std::make_shared<Primitives>(primitives)});
            renderer.draw(camera, 160, 120, {FrameImage::SplatColour});
            const Image colours = renderer.read(FrameImage::SplatColour);
            const std::vector<SeenPrimitive> seen = cast_primitives(spheres, camera, 160, 120);
            const std::vector<SeenPrimitive> same = cast_primitives(primitives, camera, 160, 120);
            int shown = 0;
            for (std::size_t i = 0; i < seen.size(); ++i) {
                EXPECT_EQ(number_of_colour(&colours.rgba[4 * i]), seen[i].number) << i;
                EXPECT_EQ(same[i].number, seen[i].number);
                shown += seen[i].number > 0;
            }
            EXPECT_GT(shown, 50);
        }
}

TEST_F(Dots, CoverAsManyPixelsFromAnyDistance) {
    renderer.load({.primitives = std::make_shared<Primitives>(
                       Primitives{.dots = {{.radius_pixels = 20}, {.radius_pixels = 20}}})});
    for (const double distance : {0.01, 1.0, 1e4}) {
        camera.eye_world = {0, 0, distance};
        renderer.draw(camera, 101, 101, {FrameImage::Hit});
        const Image hits = renderer.read(FrameImage::Hit);
        int covered = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) covered += hits.rgba[i + 3] != 0;
        // pi 20^2, by pixels' middles: some of the 125 along the border.
        EXPECT_NEAR(covered, std::numbers::pi * 400, 20) << distance;
    }
}

// The light sees the viewer's spheres: their shadow grows as the viewer goes away, and a shadow map
// is not kept from the last picture.
TEST_F(Dots, CastTheShadowsThatTheViewersSizesCast) {
    Look look;
    look.lights = {
        {.direction = Vec3d::UnitY(), .is_in_view_space = false, .shadow = Shadow::Hard}};
    const Primitives scene{.cylinders = {{.a_world = {0, -1, 0},
                                          .b_world = {0, -0.9, 0},
                                          .radius_world = 2,
                                          .is_capped = true}},
                           .dots = {{.radius_pixels = 10}}};
    renderer.load({.look = look, .primitives = std::make_shared<Primitives>(scene)});
    for (const double distance : {4.0, 8.0, 4.0}) {
        camera.eye_world = distance * Vec3d(0, 0.6, 0.8);
        const int size = 200;
        renderer.draw(camera, size, size, {FrameImage::Shadow, FrameImage::Hit});
        const Image shadows = renderer.read(FrameImage::Shadow);
        const std::vector<SeenPrimitive> seen = cast_primitives(scene, camera, size, size);
        const double radius =
            with_dots_as_spheres(scene, picture_space(camera), pixels_per_unit(camera, size))
                .spheres[0]
                .radius_world;
        int dark = 0;
        for (std::size_t i = 0; i < seen.size(); ++i) {
            if (seen[i].number != 1 || seen[i].normal.y() < 0.99) continue;
            const Ray ray =
                camera_ray(camera, size, size, double(i % size) + 0.5, double(i / size) + 0.5);
            const Vec3d p = ray.origin_world + seen[i].t * ray.direction_world;
            const double off = std::hypot(p.x(), p.z()) - radius;
            // Bilinear weights reach one and a half of the map's texels, of 4 / 200.
            if (std::abs(off) < 0.06) continue;
            EXPECT_EQ(shadows.rgba[4 * i], off < 0 ? 0 : 1) << distance << " " << off;
            dark += off < 0;
        }
        EXPECT_GT(dark, 5) << distance;
    }
}

TEST_F(Dots, AreFramedByTheirCentres) {
    renderer.load({.primitives = std::make_shared<Primitives>(
                       Primitives{.dots = {{.centre_world = {1, 2, 3}}, {.radius_pixels = 50}}})});
    renderer.draw(camera, 50, 50, {FrameImage::Hit});
    for (const Vec3d& point : renderer.surface_points_world())
        EXPECT_TRUE(point == Vec3d::Zero() || point == Vec3d(1, 2, 3));
}

} // namespace
} // namespace isocast::test
