// Lights and shading models on surfaces whose normals are known.
// SPDX-License-Identifier: MPL-2.0
#include "shading_scene.h"

#include "volume/errors.h"

namespace isocast::test {
namespace {

using Lights = Shading;

const std::shared_ptr<const FieldSource> sphere = sampled(builtin_field("sphere"), 48);

/// The beauty's texels are halves: 2^-11 of a value, and colours are near 1.
constexpr double half_rounding = 1.0 / 2048;

TEST_F(Lights, TwoAddUp) {
    const Light a{.direction = {1, 0, 0}};
    const Light b{.direction = {0, 1, 1}, .colour = {0.2, 0.5, 0.3}};
    Scene scene{.field = sphere};
    const auto picture = [&](std::vector<Light> lights) {
        scene.look.lights = std::move(lights);
        return draw(scene);
    };
    const Image of_a = picture({a});
    const Image of_b = picture({b});
    const Image of_both = picture({a, b});
    int hits = 0;
    for (std::size_t i = 0; i < of_both.rgba.size(); i += 4) {
        if (of_both.rgba[i + 3] == 0) continue;
        ++hits;
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(of_both.rgba[i + c], of_a.rgba[i + c] + of_b.rgba[i + c],
                        4 * half_rounding);
    }
    EXPECT_GT(hits, 1000);
}

TEST_F(Lights, NoneLeavesTheSurfaceBlack) {
    for (const ShadingModel model : {ShadingModel::BlinnPhong, ShadingModel::Gooch}) {
        Scene scene{.field = sphere};
        scene.look.lights.clear();
        scene.look.model = model;
        scene.look.effects.occlusion.strength = 1;
        const Image image = draw(scene);
        int hits = 0;
        for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
            if (image.rgba[i + 3] == 0) continue;
            ++hits;
            for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(image.rgba[i + c], 0);
        }
        EXPECT_GT(hits, 1000);
    }
}

TEST_F(Lights, FlatIsTheSurfaceColourAndFetchesNoGradient) {
    Scene scene{.field = sphere};
    scene.look.model = ShadingModel::Flat;
    const Image image = draw(scene);
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        const Vec3d expected =
            image.rgba[i + 3] != 0 ? scene.look.material.colour : scene.look.background;
        for (std::size_t c = 0; c < 3; ++c)
            ASSERT_NEAR(image.rgba[i + c], expected[int(c)], half_rounding);
    }
    EXPECT_FALSE(pass("gradient").ran);
}

TEST_F(Lights, GoochIsWarmTowardsTheLightAndCoolAwayFromIt) {
    Scene scene{.field = sphere};
    scene.look.model = ShadingModel::Gooch;
    scene.look.lights = {{.direction = {0, 1, 0}}};
    scene.look.material.specular = 0;
    camera = {.eye_world = {0, 0, 6}, .target_world = Vec3d::Zero()};
    const Image image = draw(scene);
    double top = 1;
    double bottom = -1;
    for (int y = 0; y < size; ++y) {
        const float* pixel = image.pixel(size / 2, y);
        if (pixel[3] == 0) continue;
        const double redness = pixel[0] - pixel[2];
        if (top == 1) top = redness;
        bottom = redness;
    }
    EXPECT_GT(top, 0.2);
    EXPECT_LT(bottom, 0.0);
}

TEST_F(Lights, GoochIsThePapersEquation) {
    Scene scene{.field = sphere};
    scene.look.model = ShadingModel::Gooch;
    scene.look.lights = {{.direction = {0.3, 1, 0.4}, .is_in_view_space = false}};
    scene.look.material.specular = 0;
    renderer.load(scene);
    renderer.draw(camera, size, size, {FrameImage::Hit, FrameImage::Beauty});
    const Image hits = renderer.read(FrameImage::Hit);
    const Image image = renderer.read(FrameImage::Beauty);
    const Vec3d to_light = scene.look.lights[0].direction.normalized();
    // Eqs 2 and 3, the warm tone towards the light: blue, yellow, alpha, beta and k_d.
    const GoochTones& tones = scene.look.tones;
    const Vec3d cool = tones.cool + tones.cool_share * scene.look.material.colour;
    const Vec3d warm = tones.warm + tones.warm_share * scene.look.material.colour;
    for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
        if (hits.rgba[i + 3] == 0) continue;
        const Vec3d p = camera.eye_world + Vec3d(hits.rgba[i], hits.rgba[i + 1], hits.rgba[i + 2]);
        const double share = (1 + to_light.dot(p.normalized())) / 2;
        const Vec3d expected = share * warm + (1 - share) * cool;
        // Normals at 15.7 voxels a radius err by 3/4/15.7^3, 2e-4 of a tone at most.
        for (std::size_t c = 0; c < 3; ++c)
            ASSERT_NEAR(image.rgba[i + c], expected[int(c)], 2e-4 + half_rounding);
    }
}

TEST_F(Lights, ThatMovesWithTheCameraDiffersFromOneThatStays) {
    Scene scene{.field = sphere};
    const Vec3d right(1, 0, 0);
    // From the side, a world-space light along x shines at the viewer's side.
    camera = {.eye_world = {6, 0, 0}, .target_world = Vec3d::Zero()};
    scene.look.lights = {{.direction = right}};
    const Image moves = draw(scene);
    scene.look.lights = {{.direction = right, .is_in_view_space = false}};
    const Image stays = draw(scene);
    const std::size_t middle = 4 * static_cast<std::size_t>(size / 2 * size + size / 2);
    EXPECT_GT(stays.rgba[middle], 2 * moves.rgba[middle]);
}

TEST_F(Lights, TooManyAreRefused) {
    Scene scene{.field = sphere};
    scene.look.lights.assign(max_light_count + 1, Light{});
    EXPECT_THROW(renderer.load(scene), InputError);
}

} // namespace
} // namespace isocast::test
