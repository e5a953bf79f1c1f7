// How often rays look at the field: counted alike whatever the blocks' order, the parts of the
// picture or the bricks at hand.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/renderer.h"
#include "test_context.h"
#include "volume/analytic_fields.h"

#include <gtest/gtest.h>

namespace isocast {
namespace {

constexpr int size = 64;

struct Steps : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders"};
    const std::shared_ptr<const FieldSource> gyroid = sampled(builtin_field("gyroid"), 48);
    const Camera camera{.eye_world = {1.6, 1.1, 4.2}};

    Image steps(const Scene& scene, const ImageSet& others = {}) {
        renderer.load(scene);
        ImageSet wanted = others;
        wanted.insert(FrameImage::Steps);
        renderer.draw(camera, size, size, wanted);
        return renderer.read(FrameImage::Steps);
    }
    static double sum(const Image& steps) {
        double total = 0;
        for (std::size_t i = 0; i < steps.rgba.size(); i += 4) total += steps.rgba[i];
        return total;
    }
};

TEST_F(Steps, AreTheSameForAnyTraversal) {
    const Image lists = steps({.field = gyroid});
    EXPECT_GT(sum(lists), size * size);
    for (const Traversal traversal :
         {Traversal::DrawnBlocks, Traversal::BoundingFaces, Traversal::Walk}) {
        SCOPED_TRACE(static_cast<int>(traversal));
        EXPECT_EQ(steps({.field = gyroid, .quality = {.traversal = traversal}}).rgba, lists.rgba);
    }
}

TEST_F(Steps, AreTheSameInAnyCompanyAndWhereBricksAreStreamed) {
    const Image alone = steps({.field = gyroid});
    EXPECT_EQ(steps({.field = gyroid}, {FrameImage::Beauty}).rgba, alone.rgba);
    Scene scene{.field = gyroid};
    scene.storage.budget_bytes = 1 << 19;
    EXPECT_EQ(steps(scene).rgba, alone.rgba);
    EXPECT_LT(renderer.pool().resident_count(), renderer.pool().brick_count());
    EXPECT_EQ(steps(scene).rgba, alone.rgba); // not added to those of the frame before
}

TEST_F(Steps, OfSamplesAreAsManyAsTheirRate) {
    // Of rays that miss: the others end with a bisection.
    renderer.load({.field = gyroid});
    renderer.draw(camera, size, size, {FrameImage::Hit});
    const Image hits = renderer.read(FrameImage::Hit);
    const auto of_misses = [&](double rate) {
        const Image counted = steps({.field = gyroid, .quality = {.rate = rate}});
        double total = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4)
            if (hits.rgba[i + 3] == 0) total += counted.rgba[i];
        return total;
    };
    // To one sample for each of the few blocks of a ray.
    EXPECT_NEAR(of_misses(32) / of_misses(16), 2, 0.05);
}

TEST_F(Steps, OfObjectsAddUp) {
    // Apart, so that no ray meets both.
    const auto ball = [](double x) {
        AnalyticField field = sphere_field(Vec3d(x, 0, 0), 0.3);
        return FieldObject{.field = sampled(std::move(field), 33)};
    };
    const Image left = steps({.objects = {ball(-0.5), ball(5)}});
    const Image right = steps({.objects = {ball(5), ball(0.5)}});
    const Image both = steps({.objects = {ball(-0.5), ball(0.5)}});
    EXPECT_GT(sum(left), 500);
    EXPECT_EQ(sum(both), sum(left) + sum(right));
}

TEST_F(Steps, AreCountedOnlyIfAskedFor) {
    renderer.load({.field = gyroid});
    const FrameReport without = renderer.draw(camera, size, size, {FrameImage::Hit});
    const FrameReport with =
        renderer.draw(camera, size, size, {FrameImage::Hit, FrameImage::Steps});
    EXPECT_EQ(without.image_bytes + 4 * size * size, with.image_bytes);
    EXPECT_EQ(with.programs_compiled, without.programs_compiled + 1);
}

} // namespace
} // namespace isocast
