// Earlier ways to draw splats, as benchmarks compare them.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/renderer.h"
#include "renderer_test_base.h"
#include "some_primitives.h"

#include <gtest/gtest.h>

#include <numbers>

namespace isocast::test {
namespace {

constexpr int width = 160;
constexpr int height = 120;

struct SplatStudies : RendererTest {
    void load(const Primitives& some) {
        renderer.load({.primitives = std::make_shared<Primitives>(some)});
    }
    SplatFragments counted(const Camera& camera, BoundingShape shape) {
        renderer.set_study({.shape = shape, .counts_fragments = true});
        return renderer.draw(camera, width, height, {FrameImage::Beauty}).splat_fragments.value();
    }
    /// Of a sphere that is 40 pixels in radius, in a scene from half to twice its distance: how
    /// many pixels the two ways tell apart.
    int missed_by_equation_7(double radius_by_distance) {
        const Vec3d eye(0.3, 0.2, 1);
        Camera camera{.eye_world = eye / radius_by_distance, .target_world = {0.3, -0.2, 0.1}};
        const double half_height = height / 2.0 / 40;
        camera.fov_y_degrees =
            2 * std::atan(half_height / camera.eye_world.norm()) * 180 / std::numbers::pi;
        const Vec3d beside = 20 * eye.unitOrthogonal(); // the picture
        load({.spheres = {{.centre_world = Vec3d::Zero(), .radius_world = 1},
                          {.centre_world = camera.eye_world / 2 + beside, .radius_world = 0.1},
                          {.centre_world = -camera.eye_world + beside, .radius_world = 0.1}}});
        std::array<Image, 2> splats;
        for (const bool by_equation_7 : {false, true}) {
            renderer.set_study({.meets_spheres_by_equation_7 = by_equation_7});
            renderer.draw(camera, width, height, {FrameImage::Splat});
            splats[by_equation_7] = renderer.read(FrameImage::Splat);
        }
        int differ = 0;
        for (std::size_t i = 0; i < splats[0].rgba.size(); i += 4)
            differ += splats[0].rgba[i] != splats[1].rgba[i];
        return differ;
    }
};

TEST_F(SplatStudies, EveryShapeShowsTheSameAndIsLargerThanTheOneBefore) {
    const Camera camera{.eye_world = {0.8, 1.1, 7}, .target_world = Vec3d::Zero()};
    Random random(2);
    load(some_quadrics(random, 6));
    std::vector<SplatFragments> counts;
    std::vector<Image> pictures;
    for (const BoundingShape shape :
         {BoundingShape::Rectangle, BoundingShape::Box, BoundingShape::Square}) {
        counts.push_back(counted(camera, shape));
        pictures.push_back(renderer.read(FrameImage::Beauty));
    }
    EXPECT_EQ(pictures[1].rgba, pictures[0].rgba);
    EXPECT_EQ(pictures[2].rgba, pictures[0].rgba);
    EXPECT_EQ(counts[1].hit, counts[0].hit);
    EXPECT_EQ(counts[2].hit, counts[0].hit);
    EXPECT_LT(counts[0].hit, counts[0].rasterised);
    EXPECT_LT(counts[0].rasterised, counts[1].rasterised);
    EXPECT_LT(counts[1].rasterised, counts[2].rasterised);
}

TEST_F(SplatStudies, FragmentsOfASphereAreThoseOfItsDiscAndOfTheSquareAroundIt) {
    Camera camera{.eye_world = {0, 0, 5}, .projection = Projection::Orthographic};
    camera.height_world = 3; // 40 pixels a unit
    load({.spheres = {{.centre_world = {0.1, 0.03, 0}, .radius_world = 1}}});
    const SplatFragments count = counted(camera, BoundingShape::Rectangle);
    const double disc = std::numbers::pi * 40 * 40;
    EXPECT_NEAR(double(count.hit), disc, 80);                // half a pixel along its border
    EXPECT_NEAR(double(count.rasterised), 80.0 * 80.0, 160); // a pixel along two sides
    renderer.draw(camera, width, height, {FrameImage::Hit});
    const Image hits = renderer.read(FrameImage::Hit);
    int seen = 0;
    for (std::size_t i = 3; i < hits.rgba.size(); i += 4) seen += hits.rgba[i] != 0;
    EXPECT_EQ(count.hit, seen);
}

TEST_F(SplatStudies, EquationSevenIsRightNearByAndLostFarAway) {
    // Of a disc of 5,000 pixels: some on its border at most, and a fifth.
    EXPECT_LE(missed_by_equation_7(0.1), 2);
    EXPECT_GT(missed_by_equation_7(1e-4), 1000);
}

} // namespace
} // namespace isocast::test
