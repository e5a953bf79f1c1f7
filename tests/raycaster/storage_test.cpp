// Pictures do not depend on how samples are stored, on what fits, or, but for what lies between
// samples, on how rays search.
// SPDX-License-Identifier: MPL-2.0
#include "../../bench/raycast/silhouette.h"
#include "raycaster/renderer.h"
#include "test_context.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

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
    std::unique_ptr<gl::Context> context = test::make_context();
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

/// A field that computes a box by many threads can be asked for it by many: while one waits for its
/// own box it must not begin another with the same memory.
TEST_F(StoredPictures, AreTheSameHoweverManyThreadsCutBricks) {
    const auto draw_it = [&] { // control samples are the field's own
        return draw({}, {}, Projection::Perspective, Filter::BSpline);
    };
    const Pictures expected = draw_it();
    constexpr int threads = 16;
    const tbb::global_control many(tbb::global_control::max_allowed_parallelism, threads);
    tbb::task_arena arena(threads);
    arena.execute([&] {
        for (int run = 0; run < 20; ++run) {
            renderer.load({.field = sampled(builtin_field("gyroid"), 16)}); // not that of before
            const Pictures drawn = draw_it();
            ASSERT_EQ(drawn.hits.rgba, expected.hits.rgba) << run;
            ASSERT_EQ(drawn.gradients.rgba, expected.gradients.rgba) << run;
        }
    });
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

/// Greatest difference of hits that are nearer to each other than `far` [voxels], and the number of
/// pixels where they are not, or only one hits.
Difference split_difference(const Image& a, const Image& b, double voxel_size, double far) {
    Difference out;
    for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
        const auto at = [&](const Image& image) {
            const auto first = image.rgba.begin() + std::ptrdiff_t(i);
            return Image{1, 1, {first, first + 4}};
        };
        const Difference d = difference(at(a), at(b), voxel_size);
        if (d.pixels != 0 || d.voxels > far)
            ++out.pixels;
        else
            out.voxels = std::max(out.voxels, d.voxels);
    }
    return out;
}

/// Two searches of the same function end within 1e-5 voxel of its root each; coordinates of 64
/// voxels round by 4e-6 a few times. Values err by 2^-20 of what a point reads, 8 voxels, which
/// moves roots by the inverse of the slope along the ray, 10 for most.
constexpr double same_root = 2e-4;

TEST_F(StoredPictures, LinearFetchesHitWhereRowsDo) {
    const double voxel = gyroid->space().voxel_size_world();
    const auto expect_same = [&](const StorageOptions& rows, const Quality& quality,
                                 Filter filter) {
        const Pictures expected = draw(rows, quality, Projection::Perspective, filter);
        // Full fractions, as llvmpipe has them, and 8 bits, as hardware does.
        for (const int fraction_bits : {0, 8}) {
            StorageOptions linear = rows;
            linear.fetch = Fetch::Linear;
            linear.fraction_bits = fraction_bits;
            const Difference d =
                split_difference(draw(linear, quality, Projection::Perspective, filter).hits,
                                 expected.hits, voxel, same_root);
            // Rays that graze a sheet closely may find either of two roots, of 7680.
            EXPECT_LE(d.pixels, 2) << filter_name(filter) << ", format " << int(rows.format)
                                   << ", bits " << fraction_bits;
        }
    };
    for (const Filter filter : {Filter::Interpolating, Filter::BSpline, Filter::Linear})
        for (const SampleFormat format :
             {SampleFormat::Float32, SampleFormat::Float16, SampleFormat::Norm16})
            expect_same({.format = format}, {}, filter);
    expect_same({}, {.rate = 2, .rate_factor = 4}, Filter::Interpolating);
}

TEST_F(StoredPictures, LinearFetchesAloneErrByTheirFractions) {
    const double voxel = gyroid->space().voxel_size_world();
    const Pictures rows = draw({});
    const auto off = [&](bool is_refined_exactly) {
        return split_difference(draw({.fetch = Fetch::Linear,
                                      .fraction_bits = 8,
                                      .is_refined_exactly = is_refined_exactly})
                                    .hits,
                                rows.hits, voxel, 0.1)
            .voxels;
    };
    // 2^-9 of a voxel's difference along each axis, over the slope along the ray.
    EXPECT_GT(off(false), 0x1p-9);
    EXPECT_LT(off(true), same_root);
}

TEST_F(StoredPictures, OfLinearFetchesHaveTheSameHitsHoweverFewBricksFit) {
    const double voxel = gyroid->space().voxel_size_world();
    StorageOptions small{.fetch = Fetch::Linear, .fraction_bits = 8};
    StorageOptions large{.fetch = Fetch::Linear, .brick_size = 16};
    for (StorageOptions storage : {small, large}) {
        const Pictures all = draw(storage);
        EXPECT_EQ(all.loaded, all.bricks);
        const int slots = storage.brick_size == 8 ? all.bricks / 2 : 1;
        storage.budget_bytes = slots * BrickLayout(storage).brick_bytes;
        const Pictures few = draw(storage);
        EXPECT_EQ(few.bricks, all.bricks);
        EXPECT_LE(renderer.pool().resident_count(), slots);
        EXPECT_GT(few.loaded, slots == 1 ? 2 * all.bricks : slots) << "bricks come and go";
        // Places in another texture round otherwise: steps may be others, their ends are not.
        EXPECT_LE(split_difference(few.hits, all.hits, voxel, same_root).pixels, 2);
    }
}

TEST_F(StoredPictures, LinearFetchesTakeTheMemoryOfSamples) {
    draw({.fetch = Fetch::Samples});
    const std::int64_t samples = renderer.pool().byte_count();
    draw({.fetch = Fetch::Linear});
    // The texture is a box of bricks: a layer more at most, one of 46.
    EXPECT_GE(renderer.pool().byte_count(), samples);
    EXPECT_LT(renderer.pool().byte_count(), 1.05 * double(samples));
}

TEST_F(StoredPictures, LinearFetchesRefuseWeightsOfBothSigns) {
    try {
        draw({.fetch = Fetch::Linear}, {}, Projection::Perspective, Filter::CatmullRom);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("catmull-rom"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("linear"), std::string::npos);
    }
}

TEST(AtlasSlots, HoldAllAndHardlyMoreInAnyTexture) {
    for (const int samples : {11, 19, 35}) {
        for (const int extent : {64, 2048, 16384}) {
            // 11 bits of x and y, 9 of z.
            const Index3 most =
                Index3(std::min(extent, 2048), std::min(extent, 2048), std::min(extent, 512)) /
                samples;
            for (const int count : {1, 2, 7, 46, 47, 1000, 34567, 2000000}) {
                const Index3 slots = atlas_slots(count, samples, extent);
                EXPECT_TRUE((slots.array() >= 1).all());
                EXPECT_TRUE((slots.array() <= most.array()).all()) << slots.transpose();
                if (count <= most.prod() / 2) {
                    EXPECT_GE(slots.prod(), count);
                    EXPECT_LE(slots.prod() - count, std::max(1, slots.x() * slots.y()))
                        << slots.transpose();
                }
            }
            EXPECT_EQ(atlas_slots(std::numeric_limits<int>::max() / 2, samples, extent), most);
        }
    }
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

/// The bound of thesis figure 6.7: half a chord as long as the distance between samples.
TEST_F(StoredPictures, SampledRaysMissNoMoreOfASilhouetteThanTheChordAllows) {
    for (const double rate : {0.5, 1.0}) {
        const SilhouetteError e = silhouette_error(renderer, 5, rate, 1, 256, 4);
        EXPECT_GT(e.missed, 100);
        EXPECT_EQ(e.false_hits, 0);
        // The surface is the sphere's within surface_error, measured at every hit.
        EXPECT_LE(e.surface_error_voxels, 1e-3);
        EXPECT_LE(e.deepest_voxels, e.bound_voxels + e.surface_error_voxels);
        // Four phases leave the deepest chord within an eighth of a step of the middle between two
        // samples, and pixels of 0.043 voxel are finer than the bound at rate 0.5.
        if (rate == 0.5) {
            EXPECT_GE(e.deepest_voxels, 0.5 * e.bound_voxels);
        }
    }
}

} // namespace
} // namespace isocast
