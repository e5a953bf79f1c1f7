// Pictures do not depend on how samples are stored, on what fits, or, but for what lies between
// samples, on how rays search.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/renderer.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace isocast {
namespace {

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

struct Pictures {
    Image hits;
    Image gradients;
    int bricks = 0;
    std::int64_t loaded = 0;
};

struct StoredPictures : testing::Test {
    std::unique_ptr<gl::Context> context = gl::make_context({.backend = gl::Backend::Osmesa});
    Renderer renderer{*context, shader_folder};
    std::shared_ptr<const FieldSource> gyroid = sampled(builtin_field("gyroid"), 64);

    Pictures draw(const StorageOptions& storage, const Quality& quality = {},
                  Projection projection = Projection::Perspective,
                  Filter filter = Filter::Interpolating) {
        renderer.load({.field = gyroid, .filter = filter, .storage = storage, .quality = quality});
        const Camera camera{.eye_world = {1.9, 1.3, 3.1},
                            .target_world = {0.1, -0.05, 0},
                            .projection = projection,
                            .height_world = 2.5};
        renderer.draw(camera, 96, 80, {FrameImage::Hit, FrameImage::Gradient});
        return {renderer.read(FrameImage::Hit), renderer.read(FrameImage::Gradient),
                renderer.pool().brick_count(), renderer.pool().loaded_count()};
    }
};

TEST_F(StoredPictures, AreTheSameHoweverFewBricksFit) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        for (const int brick_size : {8, 16}) {
            StorageOptions storage{.brick_size = brick_size};
            const Pictures all = draw(storage, {}, projection);
            EXPECT_EQ(all.loaded, all.bricks);
            const std::int64_t brick_bytes = BrickLayout(storage).brick_bytes;
            for (const int slots : {1, 7, all.bricks / 2}) {
                storage.budget_bytes = slots * brick_bytes;
                const Pictures few = draw(storage, {}, projection);
                EXPECT_EQ(few.bricks, all.bricks);
                EXPECT_EQ(few.hits.rgba, all.hits.rgba) << slots << " bricks of " << brick_size;
                EXPECT_EQ(few.gradients.rgba, all.gradients.rgba) << slots;
                if (slots == 1) {
                    EXPECT_GT(few.loaded, 2 * all.bricks) << "bricks come and go";
                }
            }
        }
    }
}

TEST_F(StoredPictures, NeedRoomForOneBrick) {
    EXPECT_THROW(draw({.budget_bytes = 100}), ResourceError);
}

TEST_F(StoredPictures, SecondFrameOfTheSameViewLoadsNothingThatStayed) {
    StorageOptions storage;
    const Pictures all = draw(storage);
    storage.budget_bytes = (all.bricks - 1) * BrickLayout(storage).brick_bytes;
    const std::int64_t first = draw(storage).loaded;
    EXPECT_LT(first, all.bricks) << "what no ray sees is not loaded";
    renderer.draw({.eye_world = {1.9, 1.3, 3.1}, .target_world = {0.1, -0.05, 0}}, 96, 80,
                  {FrameImage::Hit});
    EXPECT_EQ(renderer.pool().loaded_count(), first);
}

/// Greatest distance between the hits of two pictures [voxels], and pixels that only one hits.
struct Difference {
    double voxels = 0;
    int pixels = 0;
};

Difference difference(const Image& a, const Image& b, double voxel_size) {
    Difference out;
    for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
        if (a.rgba[i + 3] != b.rgba[i + 3]) {
            ++out.pixels;
        } else {
            const double dx = a.rgba[i] - b.rgba[i];
            const double dy = a.rgba[i + 1] - b.rgba[i + 1];
            const double dz = a.rgba[i + 2] - b.rgba[i + 2];
            out.voxels = std::max(out.voxels, std::sqrt(dx * dx + dy * dy + dz * dz) / voxel_size);
        }
    }
    return out;
}

TEST_F(StoredPictures, SampledRaysFindWhatCertifiedOnesDo) {
    const Pictures certified = draw({});
    // The gyroid's sheets are eight voxels apart and more: two samples a voxel pass between the
    // two crossings of a ray only where it grazes a sheet.
    for (const int factor : {1, 4}) {
        const Pictures at_rate = draw({}, {.rate = 8.0 / factor, .rate_factor = factor});
        int grazing = 0;
        double greatest = 0;
        const double voxel = gyroid->space().voxel_size_world();
        for (std::size_t i = 0; i < certified.hits.rgba.size(); i += 4) {
            Image one{1,
                      1,
                      {certified.hits.rgba.begin() + std::ptrdiff_t(i),
                       certified.hits.rgba.begin() + std::ptrdiff_t(i) + 4}};
            Image other{1,
                        1,
                        {at_rate.hits.rgba.begin() + std::ptrdiff_t(i),
                         at_rate.hits.rgba.begin() + std::ptrdiff_t(i) + 4}};
            const Difference d = difference(one, other, voxel);
            // A ray that enters the field's box within a step of the surface has its first sample
            // behind it. Camera::eye_world above; the gyroid's box is [-1, 1]^3.
            const Vec3d hit(certified.hits.rgba[i] + 1.9, certified.hits.rgba[i + 1] + 1.3,
                            certified.hits.rgba[i + 2] + 3.1);
            if (hit.cwiseAbs().maxCoeff() > 1 - 0.125 * voxel) continue;
            // Farther than a step: the ray passed a sheet.
            if (d.pixels != 0 || d.voxels > 0.125)
                ++grazing;
            else
                greatest = std::max(greatest, d.voxels);
        }
        // Chords shorter than 1/8 voxel belong to rays within c^2 k/8, 2e-4 voxel, of a silhouette,
        // about one ray in a thousand of those that pass one at 2 pixels a voxel.
        EXPECT_LE(grazing, 8) << factor;
        // Twelve steps of regula falsi and bisection from 1/8 voxel; float coordinates.
        EXPECT_LT(greatest, 1e-3) << factor;
    }
}

TEST_F(StoredPictures, SampledRaysDoNotSeeBricks) {
    const Quality quality{.rate = 1.0, .rate_factor = 4};
    const Pictures small = draw({.brick_size = 8}, quality);
    const Pictures large = draw({.brick_size = 32}, quality);
    EXPECT_EQ(small.hits.rgba, large.hits.rgba);
}

TEST_F(StoredPictures, SampledRaysNeedAllBricks) {
    const StorageOptions storage;
    EXPECT_THROW(draw({.budget_bytes = 4 * BrickLayout(storage).brick_bytes}, {.rate = 1.0}),
                 ResourceError);
}

TEST_F(StoredPictures, ErrOnlyAsMuchAsTheirStorage) {
    const double voxel = gyroid->space().voxel_size_world();
    for (const auto& [filter, format] : {std::pair{Filter::Interpolating, SampleFormat::Float16},
                                         std::pair{Filter::Interpolating, SampleFormat::Norm16},
                                         // Whose missing bound of the bend once overflowed, times
                                         // the large numbers that float16 stores: rays that went
                                         // away from the surface left their blocks at once.
                                         std::pair{Filter::Linear, SampleFormat::Float16}}) {
        const Pictures exact = draw({}, {}, Projection::Perspective, filter);
        const Pictures stored = draw({.format = format}, {}, Projection::Perspective, filter);
        const double error = renderer.pool().storage_error() / voxel;
        EXPECT_GT(error, 0);
        int far = 0;
        for (std::size_t i = 0; i < exact.hits.rgba.size(); i += 4) {
            const auto at = [&](const Image& image) {
                const auto first = image.rgba.begin() + std::ptrdiff_t(i);
                return Image{1, 1, {first, first + 4}};
            };
            const Difference d = difference(at(exact.hits), at(stored.hits), voxel);
            // A root moves by the error over the slope along the ray: 1/20 is a grazing ray here.
            if (d.pixels != 0 || d.voxels > 20 * error + 1e-3) ++far;
        }
        EXPECT_LT(far, 40) << "grazing rays, of 7680";
    }
}

} // namespace
} // namespace isocast
