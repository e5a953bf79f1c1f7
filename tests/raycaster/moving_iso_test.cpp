// Pictures after the iso value moved are those of a scene that is loaded there.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/random_fields.h"
#include "raycaster/renderer.h"
#include "test_context.h"
#include "volume/analytic_fields.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isocast {
namespace {

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

struct MovingIso : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer moved{*context, shader_folder};
    Renderer fresh{*context, shader_folder};
    Camera camera{.eye_world = {1.9, 1.3, 3.1}, .target_world = {0.1, -0.05, 0}};
    int pictures_with_a_surface = 0;

    void expect_the_same_at(Scene scene, const std::vector<double>& iso_values) {
        moved.load(scene);
        for (const double iso : iso_values) {
            moved.set_iso(iso);
            scene.iso_world = iso;
            fresh.load(scene);
            EXPECT_EQ(moved.pool().brick_count(), fresh.pool().brick_count()) << iso;
            EXPECT_EQ(moved.pool().storage_error(), fresh.pool().storage_error()) << iso;
            EXPECT_EQ(moved.has_surface(), fresh.has_surface()) << iso;
            EXPECT_EQ(moved.surface_box_world(), fresh.surface_box_world()) << iso;
            for (Renderer* renderer : {&moved, &fresh})
                renderer->draw(camera, 64, 48, {FrameImage::Hit, FrameImage::Gradient});
            const Image hits = fresh.read(FrameImage::Hit);
            EXPECT_EQ(moved.read(FrameImage::Hit).rgba, hits.rgba) << iso;
            EXPECT_EQ(moved.read(FrameImage::Gradient).rgba, fresh.read(FrameImage::Gradient).rgba)
                << iso;
            pictures_with_a_surface +=
                std::ranges::any_of(hits.rgba, [](float value) { return value != 0; }) ? 1 : 0;
        }
    }
};

TEST_F(MovingIso, ShowsWhatAFreshSceneDoesHoweverSamplesAreStored) {
    const std::shared_ptr<const FieldSource> gyroid = sampled(builtin_field("gyroid"), 64);
    for (const SampleFormat format :
         {SampleFormat::Float32, SampleFormat::Float16, SampleFormat::Norm16}) {
        // Small moves, large ones, to where there is no surface and back; 16 bits store with errors
        // that depend on the iso value, too.
        expect_the_same_at({.field = gyroid, .iso_world = 0.1, .storage = {.format = format}},
                           {0.1, 0.1001, 0.2, -0.15, 50, -0.16});
    }
    EXPECT_EQ(pictures_with_a_surface, 15);
}

TEST_F(MovingIso, ShowsWhatAFreshSceneDoesWithFewBricksInABand) {
    const std::shared_ptr<const FieldSource> torus = sampled(builtin_field("torus"), 64, 3.0);
    const double voxel = torus->space().voxel_size_world();
    StorageOptions storage;
    storage.budget_bytes = 20 * BrickLayout(storage).brick_bytes;
    expect_the_same_at({.field = torus, .storage = storage},
                       {0.5 * voxel, -1.5 * voxel, 2.9 * voxel, 0});
    EXPECT_EQ(pictures_with_a_surface, 4);
}

TEST_F(MovingIso, ShowsWhatAFreshSceneDoesAtPlateaus) {
    // Whole numbers, most of them in plateaus of their own: some lie at the iso value.
    const AnalyticField gyroid = builtin_field("gyroid");
    const GridSpace space = GridSpace::uniform(1.0 / 16, Vec3d::Constant(-1.5));
    std::vector<float> values;
    const IndexBox box{Index3::Zero(), Index3::Constant(48)};
    test::for_each_sample(box, [&](const Index3& at) {
        values.push_back(static_cast<float>(
            std::round(10 * gyroid.jet(space.to_world(at.cast<double>())).value)));
    });
    const auto field = std::make_shared<DenseField>(space, box, std::move(values));
    expect_the_same_at({.field = field, .filter = Filter::BSpline}, {0, 1, 0.5, 1, -1, 0});
    EXPECT_EQ(pictures_with_a_surface, 6);
}

TEST_F(MovingIso, NeedsAScene) {
    EXPECT_THROW(moved.set_iso(0), std::logic_error);
}

} // namespace
} // namespace isocast
