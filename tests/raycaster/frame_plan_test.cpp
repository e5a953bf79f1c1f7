// Which passes live; none of them runs.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/frame_plan.h"

#include "raycaster/passes.h"

#include <gtest/gtest.h>

namespace isocast {
namespace {

/// The renderer's own passes. They are never run.
struct Declared {
    gl::ShaderLibrary shaders{{std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders"}};
    gl::VertexArray no_vertices;
    Scene scene;
    FieldObject object;
    FieldOnGpu field;
    PlacesOnGpu places;
    Camera camera;
    FrameTargets targets;
    LookTextures look_textures;
    LookNumbers look_numbers;
    FrameObject one{object, field, field, field, {}, {}};
    SeenScene seen;
    FrameContext frame{shaders, no_vertices, scene, seen,    &one,          places,
                       camera,  1,           1,     targets, look_textures, look_numbers};
    std::vector<Pass> passes = declare_passes(frame);
};

std::vector<std::string> names(const std::vector<Pass>& passes) {
    std::vector<std::string> out;
    for (const Pass& pass : passes) out.emplace_back(pass.name);
    return out;
}

using Names = std::vector<std::string>;

TEST(LivePasses, RunOnlyWhatTheOutputsNeed) {
    const Declared declared;
    EXPECT_EQ(names(live_passes(declared.passes, {})), Names{});
    EXPECT_EQ(names(live_passes(declared.passes, {FrameImage::Hit})), Names{"raycast"});
    EXPECT_EQ(names(live_passes(declared.passes, {FrameImage::Gradient})),
              (Names{"raycast", "gradient"}));
    EXPECT_EQ(names(live_passes(declared.passes, {FrameImage::Curvature})),
              (Names{"raycast", "curvature"}));
    EXPECT_EQ(names(live_passes(declared.passes, {FrameImage::Beauty})),
              (Names{"raycast", "gradient", "shading"}));
    EXPECT_EQ(names(live_passes(declared.passes, {FrameImage::Direction})),
              (Names{"raycast", "direction"}));
}

TEST(LivePasses, OfFlowReadNormalsForTheSecondDirectionAlone) {
    Declared declared;
    declared.places.run_count = 1; // the surface is in sight
    Flow& flow = declared.scene.look.effects.flow;
    flow.strength = 0.5;
    EXPECT_EQ(names(live_passes(declare_passes(declared.frame), {FrameImage::Beauty})),
              (Names{"raycast", "gradient", "direction", "flow noise", "flow", "shading"}));
    EXPECT_EQ(names(live_passes(declare_passes(declared.frame), {FrameImage::Flow})),
              (Names{"raycast", "direction", "flow noise", "flow"}));
    flow.direction = 2;
    EXPECT_EQ(names(live_passes(declare_passes(declared.frame), {FrameImage::Flow})),
              (Names{"raycast", "gradient", "direction", "flow noise", "flow"}));
}

TEST(LivePasses, TheBoundsOfRaysAreForBoundingFacesAlone) {
    Declared declared;
    declared.scene.quality.traversal = Traversal::BoundingFaces;
    EXPECT_EQ(names(live_passes(declare_passes(declared.frame), {FrameImage::Hit})),
              (Names{"bounds", "raycast"}));
    for (const Traversal other : {Traversal::TileLists, Traversal::DrawnBlocks, Traversal::Walk}) {
        declared.scene.quality.traversal = other;
        EXPECT_EQ(names(live_passes(declare_passes(declared.frame), {FrameImage::Hit})),
                  Names{"raycast"});
    }
}

TEST(LivePasses, NameThePassThatReadsWhatNobodyWrote) {
    const Declared declared;
    std::vector<Pass> passes = declared.passes;
    std::erase_if(passes, [](const Pass& pass) { return pass.name == "raycast"; });
    try {
        live_passes(passes, {FrameImage::Beauty});
        FAIL() << "no error";
    } catch (const std::logic_error& error) {
        EXPECT_STREQ(error.what(), "pass 'gradient' reads 'hit', which no pass before it writes");
    }
    std::vector<Pass> wrong_order = declared.passes;
    const auto named = [&](std::string_view name) {
        return std::ranges::find(wrong_order, name, &Pass::name);
    };
    std::iter_swap(named("raycast"), named("gradient"));
    EXPECT_THROW(live_passes(wrong_order, {FrameImage::Gradient}), std::logic_error);
    EXPECT_THROW(live_passes({}, {FrameImage::Hit}), std::logic_error);
}

TEST(LivePasses, SayWhoAskedForEach) {
    const Declared declared;
    const std::vector<Pass> live =
        live_passes(declared.passes, {FrameImage::Beauty, FrameImage::Hit});
    EXPECT_EQ(asked_by(live[0], live, {FrameImage::Beauty, FrameImage::Hit}),
              "output, gradient, shading");
    EXPECT_EQ(asked_by(live[1], live, {FrameImage::Beauty, FrameImage::Hit}), "shading");
    EXPECT_EQ(asked_by(live[2], live, {FrameImage::Beauty, FrameImage::Hit}), "output");
}

} // namespace
} // namespace isocast
