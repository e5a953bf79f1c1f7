// Primitives that planes cut open, against a double ray caster.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/splat_passes.h"
#include "raycaster/splats_on_gpu.h"
#include "renderer_test_base.h"
#include "some_primitives.h"
#include "splat_judge.h"
#include "volume/errors.h"

#include <gmock/gmock.h>

namespace isocast::test {
namespace {

struct Cuts : RendererTest {
    Camera camera{.eye_world = {0.5, 1, 5}, .target_world = Vec3d::Zero()};

    FrameReport draw(const Scene& scene, const ImageSet& images, int width = 160,
                     int height = 120) {
        renderer.load(scene);
        return renderer.draw(camera, width, height, images);
    }
};

constexpr std::array all_looks{CutLook::Inside, CutLook::Flat, CutLook::Capped};

TEST_F(Cuts, OfEveryKindAreWhatTheRaysMeet) {
    Random random(5);
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        camera.height_world = 4;
        for (const CutLook look : all_looks) {
            for (int run = 0; run < 3; ++run) {
                Cut cut{.look = look, .planes = {{random.unit(), random.uniform(-0.3, 0.8)}}};
                if (run > 0) cut.planes.push_back({3 * random.unit(), random.uniform(-0.3, 0.8)});
                if (run > 1) cut.near_world = 4.6;
                // 4e-6: as of superquadrics that nothing cuts.
                const Judgement judgement =
                    judge(renderer, some_of_each(random, 5), camera, 200, 150, 4e-6, cut);
                EXPECT_EQ(judgement.wrong, 0)
                    << int(look) << ' ' << run << testing::PrintToString(judgement.pixels);
                EXPECT_GT(judgement.seen, 1000);
                EXPECT_LT(judgement.worst_error, 1e-5); // as in Splat.OfEveryKindIsWhatTheRaysMeet
            }
        }
    }
}

/// A shell, cut through its middle, across the view.
TEST_F(Cuts, ShowTheInsideAWallAsFlatAsThePlaneOrACap) {
    camera = {.eye_world = {0, 0, 5}, .target_world = Vec3d::Zero()};
    const auto ball = std::make_shared<Primitives>();
    ball->spheres = {{.radius_world = 1}};
    for (const CutLook look : all_looks) {
        draw({.primitives = ball, .cut = {.look = look, .planes = {{Vec3d::UnitZ(), 0.25}}}},
             {FrameImage::Hit, FrameImage::Gradient, FrameImage::Curvature}, 101, 101);
        const Image hits = renderer.read(FrameImage::Hit);
        const Image normals = renderer.read(FrameImage::Gradient);
        const Image curvatures = renderer.read(FrameImage::Curvature);
        // From the eye, along the view: to the far wall or to the cut, 1e-6 for some roundings.
        const double z = look == CutLook::Capped ? -4.75 : -6;
        EXPECT_NEAR(hits.pixel(50, 50)[2], z, 6e-6);
        // The far wall's normal points away; the cut's to the eye, and what is cut flat is flat.
        EXPECT_NEAR(normals.pixel(50, 50)[2], look == CutLook::Inside ? -1 : 1, 1e-6);
        EXPECT_NEAR(curvatures.pixel(50, 50)[0], look == CutLook::Inside ? 1 : 0, 1e-5);
        int caps = 0;
        int count = 0;
        for (int y = 0; y < 101; ++y)
            for (int x = 0; x < 101; ++x) {
                if (hits.pixel(x, y)[3] == 0) continue;
                ++count;
                caps += std::abs(hits.pixel(x, y)[2] + 4.75) < 1e-6;
            }
        // The disc of the cut, of radius sqrt(1 - 1/16) at distance 4.75, in pixels; its border is
        // uncertain by a pixel's width.
        const double pixel = 2 * camera.half_height_at(4.75) / 101;
        const double radius = std::sqrt(1 - 1.0 / 16) / pixel;
        const double area = std::numbers::pi * radius * radius;
        if (look == CutLook::Capped) {
            EXPECT_NEAR(caps, area, 0.2 * 2 * std::numbers::pi * radius);
        } else {
            EXPECT_EQ(caps, 0);
        }
        EXPECT_GE(count, caps);
    }
}

/// Two balls of one size that overlap: their caps meet halfway, whichever is drawn first.
TEST_F(Cuts, CapsAreOfTheSolidThatTheyLieDeepestIn) {
    camera = {.eye_world = {0.1, 0, 5}, .target_world = Vec3d::Zero()};
    std::vector<Image> pictures;
    for (const double first : {-0.5, 0.5}) {
        const auto balls = std::make_shared<Primitives>();
        for (const double x : {first, -first})
            balls->spheres.push_back({.centre_world = {x, 0, 0},
                                      .radius_world = 0.9,
                                      .colour = x < 0 ? Vec3d::UnitX() : Vec3d::UnitY()});
        draw({.primitives = balls,
              .cut = {.look = CutLook::Capped, .planes = {{Vec3d::UnitZ(), 0}}}},
             {FrameImage::Hit, FrameImage::SplatColour});
        pictures.push_back(renderer.read(FrameImage::SplatColour));
        const Image hits = renderer.read(FrameImage::Hit);
        int seen = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            const double x = hits.rgba[i] + camera.eye_world.x();
            if (hits.rgba[i + 3] == 0 || std::abs(x) < 1e-3) continue;
            ++seen;
            EXPECT_EQ(pictures.back().rgba[i], x < 0);
            EXPECT_EQ(pictures.back().rgba[i + 1], x > 0);
        }
        EXPECT_GT(seen, 2000);
    }
    EXPECT_EQ(pictures[0].rgba, pictures[1].rgba);
}

TEST_F(Cuts, SendNothingThatIsCutAway) {
    Primitives balls;
    for (int i = 0; i < 100; ++i)
        balls.spheres.push_back({.centre_world = {0.1 * (i % 10) - 0.45, 0.1 * (i / 10) - 0.45, 0},
                                 .radius_world = 0.04});
    const auto count = [&](const Cut& cut) {
        const SplatsOnGpu splats(balls, planes_of(cut, camera), camera, 320, 240,
                                 {.width = 320, .height = 240});
        return splats.kinds.empty() ? 0 : splats.kinds[0].count;
    };
    EXPECT_EQ(count({}), 100);
    EXPECT_EQ(count({.planes = {{Vec3d::UnitX(), 0}}}), 50);
    EXPECT_EQ(count({.planes = {{Vec3d::UnitX(), -0.02}}}), 50); // one row is cut
    EXPECT_EQ(count({.planes = {{-Vec3d::UnitX(), -1}}}), 0);
    EXPECT_EQ(count({.near_world = 100}), 0);
}

/// What nothing cuts is hidden by what a cut takes away, unless that counts.
TEST_F(Cuts, HideNothingWithWhatIsGone) {
    camera = {.eye_world = {0, 0, 5}, .target_world = Vec3d::Zero()};
    Primitives primitives;
    primitives.spheres = {{.centre_world = {0, 0, 1}, .radius_world = 1},
                          {.centre_world = {0, 0, -2}, .radius_world = 0.5}};
    const Cut half{.planes = {{Vec3d(1, 0, 1), 0.3}}};
    const Judgement judgement = judge(renderer, primitives, camera, 160, 120, 0, half);
    EXPECT_EQ(judgement.wrong, 0);
    EXPECT_GT(judgement.seen, 500);
}

TEST_F(Cuts, ShadowsAreThoseOfWhatIsLeft) {
    const auto balls = std::make_shared<Primitives>();
    balls->spheres = {{.centre_world = {0, 0, 1.5}, .radius_world = 0.5},
                      {.centre_world = {0, 0, 0}, .radius_world = 1}};
    Scene scene{.primitives = balls};
    scene.look.lights[0].direction = {0, 0, 1};
    scene.look.lights[0].is_in_view_space = false;
    scene.look.lights[0].shadow = Shadow::Hard;
    const auto shaded = [&](const Cut& cut) {
        scene.cut = cut;
        draw(scene, {FrameImage::Hit, FrameImage::Shadow});
        const Image shadows = renderer.read(FrameImage::Shadow);
        const Image hits = renderer.read(FrameImage::Hit);
        int count = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            const bool is_on_the_large = hits.rgba[i + 2] + camera.eye_world.z() < 0.99;
            const double x = hits.rgba[i] + camera.eye_world.x();
            const double y = hits.rgba[i + 1] + camera.eye_world.y();
            if (hits.rgba[i + 3] != 0 && is_on_the_large && std::hypot(x, y) < 0.47)
                count += shadows.rgba[i] < 0.5; // the share of light
        }
        return count;
    };
    EXPECT_GT(shaded({}), 100);
    EXPECT_EQ(shaded({.planes = {{Vec3d::UnitZ(), 1.0}}}), 0);
}

TEST_F(Cuts, WithoutPlanesAreInNoProgram) {
    Random random(1);
    const auto primitives = std::make_shared<Primitives>(some_of_each(random, 5));
    draw({.primitives = primitives}, {FrameImage::Beauty});
    const int compiled = draw({.primitives = primitives}, {FrameImage::Beauty}).programs_compiled;
    const int with_planes =
        draw({.primitives = primitives, .cut = {.planes = {{}}}}, {FrameImage::Beauty})
            .programs_compiled;
    EXPECT_GT(with_planes, compiled) << "others, with planes in them";
    EXPECT_EQ(
        draw({.primitives = primitives, .cut = {.look = CutLook::Capped}}, {FrameImage::Beauty})
            .programs_compiled,
        with_planes)
        << "a look without a plane is nothing";
}

TEST_F(Cuts, ThatCannotBeAreRefused) {
    const auto ball = std::make_shared<Primitives>();
    ball->spheres = {{}};
    const auto message = [&](const Cut& cut) -> std::string {
        try {
            renderer.load({.primitives = ball, .cut = cut});
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(message({.planes = {{}, {Vec3d::Zero(), 0}}}), testing::HasSubstr("cut plane 1"));
    EXPECT_THAT(message({.planes = {{{nan, 0, 1}, 0}}}), testing::HasSubstr("normal"));
    EXPECT_THAT(message({.planes = {{Vec3d::UnitX(), nan}}}), testing::HasSubstr("offset"));
    EXPECT_THAT(message({.planes = std::vector<CutPlane>(9)}), testing::HasSubstr("8 at most"));
    EXPECT_THAT(message({.near_world = 0}), testing::HasSubstr("near"));
}

} // namespace
} // namespace isocast::test
