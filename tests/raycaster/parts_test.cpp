// Parts of pictures are, bit by bit, what the whole picture shows there; shifted rays are those of
// a finer picture.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/renderer.h"
#include "test_context.h"
#include "volume/analytic_fields.h"

#include <gtest/gtest.h>

namespace isocast {
namespace {

struct Parts : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders"};
    Camera camera{.eye_world = {1.6, 1.2, 3.5}, .target_world = {0.1, 0, 0}};
    static constexpr int width = 61;
    static constexpr int height = 47;

    /// Draws parts that lie across the picture's tiles of 4^2 pixels, and expects the whole's bits.
    void expect_same_bits(const ImageSet& wanted, std::initializer_list<FrameImage> images) {
        renderer.draw(camera, width, height, wanted);
        std::vector<Image> whole;
        for (const FrameImage image : images) whole.push_back(renderer.read(image));
        int hits = 0;
        for (const PicturePart& part : {PicturePart{.x = 0, .y = 0, .width = 13, .height = 47},
                                        PicturePart{.x = 13, .y = 5, .width = 41, .height = 30},
                                        PicturePart{.x = 22, .y = 19, .width = 1, .height = 1},
                                        PicturePart{.x = 54, .y = 35, .width = 7, .height = 12}}) {
            renderer.draw(camera, width, height, wanted, part);
            std::size_t number = 0;
            for (const FrameImage image : images) {
                const Image drawn = renderer.read(image);
                ASSERT_EQ(drawn.width, part.width);
                ASSERT_EQ(drawn.height, part.height);
                for (int y = 0; y < part.height; ++y)
                    for (int x = 0; x < part.width; ++x) {
                        const float* expected = whole[number].pixel(part.x + x, part.y + y);
                        hits += expected[3] != 0;
                        for (int c = 0; c < 4; ++c)
                            ASSERT_EQ(drawn.pixel(x, y)[c], expected[c])
                                << name_of(image) << " at " << part.x + x << ", " << part.y + y;
                    }
                ++number;
            }
        }
        EXPECT_GT(hits, 500);
    }
};

TEST_F(Parts, EqualTheWholeBitByBit) {
    const std::shared_ptr<const FieldSource> field = sampled(builtin_field("torus"), 40);
    for (const Traversal traversal : {Traversal::TileLists, Traversal::DrawnBlocks,
                                      Traversal::BoundingFaces, Traversal::Walk}) {
        SCOPED_TRACE(static_cast<int>(traversal));
        renderer.load({.field = field, .quality = {.traversal = traversal}});
        expect_same_bits({FrameImage::Hit, FrameImage::Beauty},
                         {FrameImage::Hit, FrameImage::Beauty});
    }
}

TEST_F(Parts, EqualTheWholeForParallelRaysCurvatureEnvironmentAndSamplesAtARate) {
    camera.projection = Projection::Orthographic;
    camera.height_world = 3;
    Scene scene{.field = sampled(builtin_field("gyroid"), 32), .quality = {.rate = 4}};
    scene.look.shows_environment = true;
    renderer.load(scene);
    expect_same_bits({FrameImage::Curvature, FrameImage::Beauty},
                     {FrameImage::Curvature, FrameImage::Beauty});
}

TEST_F(Parts, EqualTheWholeWhereBricksAreStreamed) {
    Scene scene{.field = sampled(builtin_field("gyroid"), 48)};
    scene.storage.budget_bytes = 1 << 19;
    renderer.load(scene);
    ASSERT_LT(renderer.pool().resident_count(), renderer.pool().brick_count());
    expect_same_bits({FrameImage::Hit}, {FrameImage::Hit});
}

TEST_F(Parts, ShiftedByAQuarterPixelAreEveryOtherPixelOfAPictureOfTwiceTheSize) {
    // Pixel (i, j) of the fine picture has its centre a quarter of a coarse pixel off that of
    // (i/2, j/2).
    renderer.load({.field = sampled(builtin_field("torus"), 40)});
    renderer.draw(camera, 2 * width, 2 * height, {FrameImage::Hit});
    const Image fine = renderer.read(FrameImage::Hit);
    int hits = 0;
    int on_one_alone = 0;
    for (const int i : {0, 1})
        for (const int j : {0, 1}) {
            renderer.draw(camera, width, height, {FrameImage::Hit},
                          PicturePart{.width = width,
                                      .height = height,
                                      .shift = {i / 2.0 - 0.25, j / 2.0 - 0.25}});
            const Image shifted = renderer.read(FrameImage::Hit);
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x) {
                    const float* a = shifted.pixel(x, y);
                    const float* b = fine.pixel(2 * x + i, 2 * y + j);
                    if ((a[3] == 0) != (b[3] == 0)) {
                        ++on_one_alone;
                        continue;
                    }
                    hits += a[3] != 0;
                    // 1e-5: the rays are affine maps of other numbers, rounded to 2^-24 of a
                    // distance of 4, and hits where they meet the surface at 0.1 rad move by ten
                    // times that.
                    for (int c = 0; c < 3; ++c) ASSERT_NEAR(a[c], b[c], 1e-5);
                }
        }
    EXPECT_GT(hits, 1000);
    EXPECT_EQ(on_one_alone, 0);
}

} // namespace
} // namespace isocast
