// A renderer that keeps parts draws again only what changed, and the same as one that keeps
// nothing.
// SPDX-License-Identifier: MPL-2.0
#include "effect_rules.h"
#include "quadrics/primitives.h"
#include "raycaster/image.h"

#include <random>

namespace isocast::test {
namespace {

using Names = std::set<std::string>;

struct KeptImages : Shading {
    Scene scene{.field = sampled(builtin_field("torus"), 40)};

    KeptImages() { renderer.keep_parts(4); }

    Image fresh(const PicturePart& part, FrameImage image = FrameImage::Beauty) {
        Renderer other(*context, shader_folder);
        other.load(scene);
        other.set_look_numbers(renderer.look_numbers());
        other.draw(camera, size, size, {image}, part);
        return other.read(image);
    }
    PicturePart whole() const { return {.width = size, .height = size}; }

    /// Draws with the scene's look: it must run these passes, and be as nothing kept gives it.
    void expect_runs(const Names& names, const PicturePart& part,
                     FrameImage image = FrameImage::Beauty) {
        renderer.set_look(scene.look);
        report = renderer.draw(camera, size, size, {image}, part);
        EXPECT_EQ(passes_run(report), names);
        EXPECT_EQ(renderer.read(image), fresh(part, image));
    }
    void expect_runs(const Names& names) { expect_runs(names, whole()); }
};

TEST_F(KeptImages, ALookRunsWhatItChanges) {
    renderer.load(scene);
    expect_runs({"raycast", "gradient", "shading"});
    expect_runs({});
    scene.look.lights[0].colour = {1, 0.5, 0.2};
    expect_runs({"shading"});
    scene.look.lights[0].direction = {1, 0.4, 0.3};
    expect_runs({"shading"});
    scene.look.lights[0].shadow = Shadow::Hard;
    expect_runs({"shadow map", "shadow", "shading"});
    scene.look.lights[0].shadow_strength = 0.5;
    expect_runs({"shading"});
    scene.look.lights[0].shadow = Shadow::Soft;
    expect_runs({"shadow", "shading"});
    scene.look.lights[0].shadow = Shadow::None;
    CurvatureColour& colour = scene.look.effects.curvature_colour;
    colour.strength = 1;
    expect_runs({"curvature", "curvature colour", "shading"});
    colour.map = ColourMap::Viridis;
    expect_runs({"curvature colour", "shading"});
    colour.measure = CurvatureMeasure::K1;
    expect_runs({"curvature colour", "shading"});
    scene.look.effects.flow.strength = 1; // of second order, like curvatures: these come together
    expect_runs({"curvature", "curvature colour", "direction", "flow noise", "flow", "shading"});
    scene.look.effects.flow.length_pixels = 7;
    expect_runs({"flow", "shading"});
    scene.look.effects.flow.grain_pixels = 3;
    expect_runs({"flow noise", "flow", "shading"});
    scene.look.effects.reflection = {.strength = 1, .has_fresnel = true};
    expect_runs({"reflection", "shading"});
    scene.look.effects.refraction.index = 2;
    expect_runs({"reflection", "shading"});
    scene.look.environment.kind = Environment::Kind::Stripes;
    expect_runs({"reflection", "shading"});
    scene.look.background = Vec3d::Zero();
    expect_runs({"shading"});
    scene.look.model = ShadingModel::Flat;
    expect_runs({"shading"});
}

TEST_F(KeptImages, WhatIsFoundWithHitsIsFoundWithThemAgain) {
    renderer.load(scene);
    expect_runs({"raycast", "gradient", "shading"});
    expect_runs({"raycast", "steps"}, whole(), FrameImage::Steps);
    expect_runs({}, whole(), FrameImage::Steps);
    expect_runs({"gradient", "shading"}); // hits are kept
}

TEST_F(KeptImages, AreThoseOfTheirPart) {
    renderer.load(scene);
    const PicturePart left{.width = size / 2, .height = size};
    const PicturePart right{.x = size / 2, .width = size / 2, .height = size};
    PicturePart shifted = right;
    shifted.shift = {0.25, -0.5};
    const Names all{"raycast", "gradient", "shading"};
    expect_runs(all, left);
    expect_runs(all, right);
    scene.look.material.colour = {0.1, 0.7, 0.2};
    expect_runs({"shading"}, left);
    expect_runs({"shading"}, right);
    expect_runs(all, shifted);
    expect_runs({}, left);
    expect_runs(all, right); // the other sample took its place
    camera.eye_world.x() += 0.5;
    expect_runs(all, left);
    expect_runs(all, right); // in the place of the last of the other picture
    camera.eye_world.x() -= 0.5;
    expect_runs(all, right);
}

TEST_F(KeptImages, TheShadowMapIsOneForAllParts) {
    scene.look.lights[0] = {.direction = {1, 0.4, 0.3}, .shadow = Shadow::Hard};
    renderer.load(scene);
    const PicturePart left{.width = size / 2, .height = size};
    const PicturePart right{.x = size / 2, .width = size / 2, .height = size};
    const Names all{"raycast", "gradient", "shadow", "shading"};
    expect_runs({"raycast", "gradient", "shadow map", "shadow", "shading"}, left);
    const std::int64_t map_bytes = pass("shadow map").texture_bytes;
    EXPECT_GT(map_bytes, 0);
    expect_runs(all, right);
    scene.look.lights[0].direction = {1, 0.5, 0.3};
    expect_runs({"shadow map", "shadow", "shading"}, left);
    expect_runs({"shadow", "shading"}, right);
}

TEST_F(KeptImages, ANewSurfaceForgetsThem) {
    const Names all{"raycast", "gradient", "shading"};
    renderer.load(scene);
    expect_runs(all);
    scene.iso_world = 0.05;
    renderer.set_iso(0.05);
    expect_runs(all);
    scene.quality.guarantee_voxels = 1;
    renderer.set_quality(scene.quality);
    expect_runs(all);
    scene.field = sampled(builtin_field("gyroid"), 32);
    renderer.load(scene);
    expect_runs(all);
}

/// Effects on, off and changed at random, beside primitives: as if nothing were kept.
TEST_F(KeptImages, AreWhatTheyWouldBeDrawnAnew) {
    auto primitives = std::make_shared<Primitives>();
    primitives->spheres.push_back({.centre_world = Vec3d(0.9, 0, 0.4), .radius_world = 0.3});
    for (const bool has_primitives : {false, true}) {
        scene.primitives = has_primitives ? primitives : nullptr;
        scene.look = {};
        renderer.load(scene);
        std::mt19937 random(5);
        Effects& e = scene.look.effects;
        const std::array strengths{&e.solid_texture.strength, &e.curvature_colour.strength,
                                   &e.curvature_map.strength, &e.uncertainty.strength,
                                   &e.flow.strength,          &e.accessibility.strength,
                                   &e.ridges.strength,        &e.contours.strength,
                                   &e.outlines.strength};
        for (int i = 0; i < 15; ++i) {
            const std::size_t which = random() % (strengths.size() + 3);
            if (which < strengths.size())
                *strengths[which] = double(random() % 3) / 2;
            else if (which == strengths.size())
                e.contours.thickness_pixels = 1 + double(random() % 3);
            else if (which == strengths.size() + 1)
                scene.look.lights[0].shadow = Shadow(random() % 3);
            else
                e.solid_texture.kind = SolidTexture::Kind(random() % 4);
            renderer.set_look(scene.look);
            renderer.draw(camera, size, size, {FrameImage::Beauty});
            ASSERT_EQ(renderer.read(FrameImage::Beauty), fresh(whole())) << i;
        }
    }
}

} // namespace
} // namespace isocast::test
