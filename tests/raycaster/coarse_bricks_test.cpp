// Pictures of fields whose bricks were coarsened to fit a budget: no holes, and no hit farther off
// than the residual allows.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/coarse_bricks.h"

#include "raycaster/renderer.h"
#include "search_judge.h"
#include "test_context.h"
#include "volume/errors.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <mutex>

namespace isocast {
namespace {

using namespace test;

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

TEST(CoarseLayout, GivesEachTexelToOneBrick) {
    for (const Fetch fetch : {Fetch::Rows, Fetch::Samples}) {
        const LevelCounts counts{60, 131, 250, 400};
        const CoarseLayout layout(fetch, counts);
        std::vector<std::uint8_t> is_used(static_cast<std::size_t>(layout.texels));
        std::int64_t used = 0;
        for (int level = 0; level <= coarsest_level; ++level) {
            const int cells = block_size >> level;
            const int row = fetch == Fetch::Rows ? cells : cells + 3;
            for (int i = 0; i < counts[static_cast<std::size_t>(level)]; ++i) {
                for (int z = 0; z < cells + 3; ++z) {
                    for (int y = 0; y < cells + 3; ++y) {
                        for (int x = 0; x < row; ++x, ++used) {
                            const auto texel = static_cast<std::size_t>(layout.address(level, i) +
                                                                        x + y * layout.row_stride +
                                                                        z * layout.plane_stride);
                            ASSERT_LT(texel, is_used.size());
                            ASSERT_EQ(is_used[texel]++, 0);
                        }
                    }
                }
            }
        }
        // Half full at least, with a group begun at each level.
        EXPECT_GT(used, layout.texels / 2);
    }
}

/// Distances of a torus, clamped or not; unit voxels.
std::shared_ptr<const FieldSource> torus(int n, double half_width) {
    const AnalyticField field = torus_field(Vec3d::Constant(0.5 * n) + Vec3d(0.137, -0.241, 0.319),
                                            {0.3, 1, 0.5}, 0.28 * n, 0.11 * n);
    const IndexBox extent{Index3::Zero(), Index3::Constant(n)};
    std::vector<float> values;
    for_each_sample(extent, [&](const Index3& i) {
        values.push_back(static_cast<float>(
            std::clamp(field.jet(i.cast<double>()).value, -half_width, half_width)));
    });
    return std::make_shared<DenseField>(GridSpace::uniform(1), extent, std::move(values),
                                        half_width < 100 ? std::optional(half_width)
                                                         : std::nullopt);
}

/// A ball of 0.36 n with bumps, in a band of 5.
std::shared_ptr<const FieldSource> bumpy_ball(int n) {
    const IndexBox extent{Index3::Zero(), Index3::Constant(n)};
    std::vector<float> values;
    for_each_sample(extent, [&](const Index3& i) {
        const Vec3d p = i.cast<double>() - Vec3d::Constant(0.5 * n - 0.3);
        const double bumps = std::sin(0.8 * p.x()) * std::sin(0.9 * p.y()) * std::sin(0.7 * p.z());
        // Bumps on one side only, so that residuals differ.
        const double height = p.x() > 0 ? 0.03 * p.x() * bumps : 0;
        values.push_back(static_cast<float>(std::clamp(p.norm() - 0.36 * n + height, -5.0, 5.0)));
    });
    return std::make_shared<DenseField>(GridSpace::uniform(1), extent, std::move(values), 5.0);
}

/// Ripples of two voxels, which end just below the faces between blocks at z = 32: their coarse
/// samples are all crests, so that the coarse surface lies in the blocks above.
std::shared_ptr<const FieldSource> ripples(int n) {
    return control_of(n, [](const Vec3d& p) {
        // The spline of the ripples is a third as high: its crests are at 31.87, coarse ones
        // at 32.2.
        return p.z() - 31.7 - (static_cast<int>(p.x()) % 2 == 0 ? 0.5 : -0.5);
    });
}

struct Case {
    std::string name;
    std::shared_ptr<const FieldSource> samples;
    Filter filter = Filter::Interpolating;
};

std::vector<Case> cases(int n) {
    return {{"torus", torus(n, 1000)},
            {"torus in a band of 3", torus(n, 3)},
            {"bumpy ball", bumpy_ball(n)},
            {"noise", smooth_noise(n, 1).control, Filter::BSpline},
            {"ripples", ripples(n), Filter::BSpline}};
}

std::vector<Camera> cameras_of(int n) {
    const Vec3d middle = Vec3d::Constant(0.5 * n);
    return {{.eye_world = middle + 2.0 * n * Vec3d(0.5, 0.4, 1).normalized(),
             .target_world = middle,
             .fov_y_degrees = 34},
            {.eye_world = middle + 2.0 * n * Vec3d(-1, 0.3, 0.2).normalized(),
             .target_world = middle,
             .projection = Projection::Orthographic,
             .height_world = 1.05 * n},
            {.eye_world = middle + 2.0 * n * Vec3d(0, 0, 1), // along an axis
             .target_world = middle,
             .projection = Projection::Orthographic,
             .height_world = 0.9 * n}};
}

struct CoarsePictures : testing::Test {
    static constexpr int n = 64;
    static constexpr int size = 64;
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, shader_folder};

    /// Loads the field with a fraction of the memory that all its bricks take.
    void load(const Case& field, double fraction, StorageOptions storage = {}) {
        renderer.load({.field = field.samples, .filter = field.filter, .storage = storage});
        storage.budget_bytes = static_cast<std::int64_t>(
            fraction * double(renderer.pool().brick_count() * BrickLayout(storage).brick_bytes));
        storage.over_budget = OverBudget::Coarsen;
        renderer.load({.field = field.samples, .filter = field.filter, .storage = storage});
        ASSERT_EQ(renderer.coarse_bricks().has_value(), fraction < 1);
        // 32 bytes a block: its record.
        EXPECT_LE(renderer.pool().byte_count(),
                  storage.budget_bytes + 32 * renderer.pool().brick_count());
    }
};

TEST_F(CoarsePictures, ShowTheSplineThatTheCoarseBricksMake) {
    for (const Case& field : cases(n)) {
        for (const double fraction : {0.4, 0.08}) {
            load(field, fraction);
            ASSERT_TRUE(renderer.coarse_bricks());
            const CoarseBricks& coarse = *renderer.coarse_bricks();
            EXPECT_GT(coarse.coarse_count(), 0);
            const Subject subject{.name = field.name, .samples = coarse.field};
            SearchOracle oracle = oracle_of(subject);
            oracle.prepare(field.name == "noise" ? 3 : 1.5); // not reached by these fields
            Verdict sum;
            std::mutex mutex;
            for (const Camera& camera : cameras_of(n)) {
                renderer.draw(camera, size, size, {FrameImage::Hit});
                const Image image = renderer.read(FrameImage::Hit);
                tbb::parallel_for(0, size, [&](int y) {
                    Verdict row;
                    for (int x = 0; x < size; ++x) row += judge_pixel(oracle, camera, image, x, y);
                    const std::lock_guard lock(mutex);
                    sum += row;
                });
            }
            EXPECT_TRUE(sum.is_right()) << field.name << ", " << fraction << ": " << sum;
            EXPECT_GT(sum.certain, 2000) << field.name;
            EXPECT_GT(sum.transversal, 0.8 * sum.certain) << field.name;
        }
    }
}

TEST_F(CoarsePictures, HaveNoHolesAndNoHitsBeyondTheResidual) {
    for (const Case& field : cases(n)) {
        const auto control = control_samples(field.samples, field.filter);
        for (const double fraction : {0.6, 0.25, 0.1}) {
            load(field, fraction);
            const CoarseBricks& coarse = *renderer.coarse_bricks();
            // Places of hits: 1e-4 voxel of float coordinates, and values 2^-20 of the greatest.
            const double slack = 1e-3 + 0x1p-19 * coarse.greatest_value;
            const double residual = coarse.greatest_residual + slack;
            const ReferenceCaster exact(*control, 0, {.step_voxels = 0.1});
            const ReferenceCaster deep(*control, -residual, {.step_voxels = 0.1});
            int sure = 0;
            double greatest = 0;
            for (const Camera& camera : cameras_of(n)) {
                renderer.draw(camera, size, size, {FrameImage::Hit});
                const Image image = renderer.read(FrameImage::Hit);
                for (int y = 0; y < size; ++y) {
                    for (int x = 0; x < size; ++x) {
                        const float* hit = image.pixel(x, y);
                        const Ray ray = unit_ray(camera, size, size, x, y);
                        const auto inside = deep.hit(ray);
                        const Vec3d p = camera.eye_world + Vec3d(hit[0], hit[1], hit[2]);
                        // Where the ray starts inside the noise the picture has what comes later.
                        const bool is_outside_first =
                            inside &&
                            exact.value(ray.origin_world + span_in(ray, control->extent()).begin *
                                                               ray.direction_world) > residual;
                        sure += is_outside_first;
                        if (is_outside_first) {
                            ASSERT_NE(hit[3], 0) << field.name << ": a hole at " << x << ", " << y;
                            // No later than where the ray is sure to be inside.
                            EXPECT_LE((p - ray.origin_world).dot(ray.direction_world),
                                      *inside + 1e-3);
                        }
                        if (hit[3] == 0) continue;
                        const double error = std::abs(exact.value(p));
                        greatest = std::max(greatest, error);
                        EXPECT_LE(error, residual) << field.name;
                    }
                }
            }
            EXPECT_GT(sure, 2000) << field.name;
            // The bound says something: it is the hull's, not the greatest error on the surface.
            EXPECT_GT(greatest, 0.05 * coarse.greatest_residual) << field.name << " " << fraction;
            RecordProperty(field.name + std::to_string(int(100 * fraction)),
                           std::to_string(coarse.greatest_residual) + " " +
                               std::to_string(greatest));
        }
    }
}

TEST_F(CoarsePictures, HaveTheGradientsOfTheSpline) {
    for (const double fraction : {0.4, 0.1}) {
        load(cases(n)[2], fraction);
        const CoarsenedField& control = *renderer.coarse_bricks()->field;
        const Camera camera = cameras_of(n)[0];
        renderer.draw(camera, size, size, {FrameImage::Hit, FrameImage::Gradient});
        const Image hits = renderer.read(FrameImage::Hit);
        const Image gradients = renderer.read(FrameImage::Gradient);
        double greatest = 0;
        int count = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            if (hits.rgba[i + 3] == 0) continue;
            ++count;
            const Vec3d p =
                camera.eye_world + Vec3d(hits.rgba[i], hits.rgba[i + 1], hits.rgba[i + 2]);
            const Vec3d g(gradients.rgba[i], gradients.rgba[i + 1], gradients.rgba[i + 2]);
            greatest = std::max(greatest, (g - tricubic_jet(control, p).gradient).norm());
        }
        EXPECT_GT(count, 1000);
        // Coordinates round by 2e-5 voxel where the gradient changes by up to 1 a voxel, and values
        // of 5 by 2^-20.
        EXPECT_LT(greatest, 2e-4);
    }
}

TEST_F(CoarsePictures, AreTheOrdinaryOnesIfAllBricksFit) {
    const Case field = cases(n)[1];
    const Camera camera = cameras_of(n)[0];
    renderer.load({.field = field.samples});
    renderer.draw(camera, size, size, {FrameImage::Hit, FrameImage::Gradient});
    const Image hits = renderer.read(FrameImage::Hit);
    const Image gradients = renderer.read(FrameImage::Gradient);
    load(field, 1);
    EXPECT_FALSE(renderer.coarse_bricks());
    renderer.draw(camera, size, size, {FrameImage::Hit, FrameImage::Gradient});
    EXPECT_EQ(renderer.read(FrameImage::Hit).rgba, hits.rgba);
    EXPECT_EQ(renderer.read(FrameImage::Gradient).rgba, gradients.rgba);
}

TEST_F(CoarsePictures, DoNotDependOnTheFetchAndErrByTheirStorage) {
    const Case field = cases(n)[2];
    const Camera camera = cameras_of(n)[1];
    for (const SampleFormat format :
         {SampleFormat::Float32, SampleFormat::Float16, SampleFormat::Norm16}) {
        for (const Fetch fetch : {Fetch::Rows, Fetch::Samples}) {
            load(field, 0.3, {.fetch = fetch, .format = format});
            Subject subject{.name = "bumpy ball", .samples = renderer.coarse_bricks()->field};
            // On both sides of a face between resolutions once.
            subject.storage_error = 2 * renderer.pool().storage_error();
            SearchOracle oracle = oracle_of(subject);
            oracle.prepare(1.5);
            renderer.draw(camera, size, size, {FrameImage::Hit});
            const Image image = renderer.read(FrameImage::Hit);
            Verdict sum;
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) sum += judge_pixel(oracle, camera, image, x, y);
            EXPECT_TRUE(sum.is_right()) << int(format) << ", " << int(fetch) << ": " << sum;
            EXPECT_GT(sum.certain, 1000);
        }
    }
}

TEST_F(CoarsePictures, CanBeSampledAtARate) {
    const Case field = cases(n)[2];
    load(field, 0.25);
    const Camera camera = cameras_of(n)[0];
    renderer.draw(camera, size, size, {FrameImage::Hit});
    const Image certified = renderer.read(FrameImage::Hit);
    const StorageOptions storage{.budget_bytes = renderer.pool().byte_count(),
                                 .over_budget = OverBudget::Coarsen};
    renderer.load({.field = field.samples, .storage = storage, .quality = {.rate = 4.0}});
    const ReferenceCaster caster(*renderer.coarse_bricks()->field, 0, {.step_voxels = 0.1});
    renderer.draw(camera, size, size, {FrameImage::Hit});
    const Image at_rate = renderer.read(FrameImage::Hit);
    int hits = 0;
    for (std::size_t i = 0; i < at_rate.rgba.size(); i += 4) {
        if (at_rate.rgba[i + 3] == 0) continue;
        ++hits;
        const Vec3d p =
            camera.eye_world + Vec3d(at_rate.rgba[i], at_rate.rgba[i + 1], at_rate.rgba[i + 2]);
        EXPECT_LT(std::abs(caster.value(p)), 1e-3); // as storage_test.cpp has it
    }
    EXPECT_GT(hits, 1000);
}

TEST_F(CoarsePictures, RefuseWhatTheyCannotDo) {
    const Case field = cases(n)[1];
    const auto with = [&](StorageOptions storage, Filter filter) {
        storage.over_budget = OverBudget::Coarsen;
        renderer.load({.field = field.samples, .filter = filter, .storage = storage});
    };
    EXPECT_THROW(with({}, Filter::Linear), InputError);
    EXPECT_THROW(with({}, Filter::CatmullRom), InputError);
    EXPECT_THROW(with({.brick_size = 16}, Filter::Interpolating), InputError);
    try {
        with({.budget_bytes = 2000}, Filter::Interpolating);
        FAIL();
    } catch (const ResourceError& error) {
        EXPECT_NE(std::string(error.what()).find("need"), std::string::npos) << error.what();
    }
}

} // namespace
} // namespace isocast
