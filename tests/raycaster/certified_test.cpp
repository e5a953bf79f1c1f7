// The certified search against the reference caster, on fields that ray casters miss: no stretch
// inside longer than the guarantee is missed, no hit is false, and each is the first.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/renderer.h"
#include "search_judge.h"
#include "test_context.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <sstream>

namespace isocast {
namespace {

using namespace test;

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

struct Certified : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, shader_folder};

    void load(const Subject& subject) {
        renderer.load({.field = subject.samples,
                       .iso_world = subject.iso,
                       .filter = subject.filter,
                       .storage = subject.storage,
                       .quality = {.guarantee_voxels = guarantee}});
    }
    Image draw(const Camera& camera, int size) {
        renderer.draw(camera, size, size, {FrameImage::Hit});
        return renderer.read(FrameImage::Hit);
    }

    /// Draws the pictures and judges every pixel.
    Verdict judge(const Subject& subject, const std::vector<Camera>& cameras, int size = 64) {
        load(subject);
        SearchOracle oracle = oracle_of(subject);
        oracle.prepare(cameras, size, size);
        Verdict sum;
        std::mutex mutex;
        for (const Camera& camera : cameras) {
            const Image image = draw(camera, size);
            tbb::parallel_for(0, size, [&](int y) {
                Verdict row;
                for (int x = 0; x < size; ++x) row += judge_pixel(oracle, camera, image, x, y);
                const std::lock_guard lock(mutex);
                sum += row;
            });
        }
        EXPECT_TRUE(sum.is_right())
            << subject.name << ", " << filter_name(subject.filter) << ": " << sum;
        RecordProperty(subject.name, (std::ostringstream{} << sum).str());
        return sum;
    }
};

/// From outside the cube [0, n)^3, perspective and orthographic, no axis along the view.
std::vector<Camera> oblique_cameras(int n, unsigned seed, int count) {
    Random random(seed);
    std::vector<Camera> cameras;
    for (int i = 0; i < count; ++i) {
        const Vec3d middle = Vec3d::Constant(0.5 * (n - 1));
        Camera camera{.eye_world = middle + 3 * n * random_point(random, -1, 1).normalized(),
                      .target_world = middle,
                      .up = random_point(random, -1, 1)};
        camera.height_world = 1.3 * n;
        if (i % 2 == 1) camera.projection = Projection::Orthographic;
        cameras.push_back(camera);
    }
    return cameras;
}

/// Along each axis, orthographic: every ray has two components that are zero.
std::vector<Camera> axis_cameras(int n) {
    std::vector<Camera> cameras;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3d middle = Vec3d::Constant(0.5 * (n - 1));
        cameras.push_back({.eye_world = middle + (axis == 1 ? -2 * n : 2 * n) * Vec3d::Unit(axis),
                           .target_world = middle,
                           .up = Vec3d::Unit((axis + 1) % 3),
                           .projection = Projection::Orthographic,
                           .height_world = 1.0 * n});
    }
    return cameras;
}

TEST_F(Certified, NothingIsMissedFromOutside) {
    constexpr int n = 32;
    for (unsigned seed = 1; seed <= 2; ++seed) {
        for (const HardField& field : hard_fields(n, seed)) {
            const Verdict v = judge(subject_of(field), oblique_cameras(n, seed, 4));
            // Tests test something: most of the rays that hit had to.
            EXPECT_GT(v.certain, 500) << field.name;
            EXPECT_GT(v.certain, 0.9 * v.hits) << field.name;
        }
    }
}

TEST_F(Certified, NothingIsMissedAlongTheAxes) {
    constexpr int n = 32;
    for (const HardField& field : hard_fields(n, 3)) {
        const Verdict v = judge(subject_of(field), axis_cameras(n));
        EXPECT_GT(v.certain, 300) << field.name;
    }
}

TEST_F(Certified, NothingIsMissedOfASheetSeenEdgeOn) {
    constexpr int n = 32;
    const ThinSheet sheet = thin_sheet(n, 4);
    Random random(4);
    std::vector<Camera> cameras;
    // In the sheet's plane or 0.1 to 0.001 voxel above it, and looking along it or nearly so.
    for (const double height : {0.0, 0.001, 0.02, 0.1}) {
        const Vec3d along = sheet.normal.cross(random_point(random, -1, 1)).normalized();
        cameras.push_back({.eye_world = sheet.p_on_sheet + 60 * along + height * sheet.normal,
                           .target_world = sheet.p_on_sheet,
                           .up = sheet.normal,
                           .fov_y_degrees = height == 0 ? 1.0 : 10.0});
    }
    const Verdict v = judge(subject_of(sheet.field), cameras);
    EXPECT_GT(v.certain, 4000);
}

TEST_F(Certified, NothingIsMissedOfATorusSeenEdgeOn) {
    constexpr int n = 48;
    const Vec3d centre(23.3, 23.9, 23.6);
    const Vec3d axis = Vec3d(0.2, -0.3, 1).normalized();
    const AnalyticField torus = torus_field(centre, axis, 16, 2.5);
    const auto control = control_of(n, [&](const Vec3d& p) { return torus.jet(p).value; });
    const Vec3d along = axis.cross(Vec3d(1, 2, 3)).normalized();
    std::vector<Camera> cameras;
    // At the heights of the tube's top, where rays graze it for long, of its middle and between.
    for (const double height : {0.0, 1.5, 2.4, 2.49, 2.5, 2.51})
        cameras.push_back({.eye_world = centre + 100 * along + height * axis,
                           .target_world = centre + height * axis,
                           .up = axis,
                           .projection = Projection::Orthographic,
                           .height_world = 0.5});
    cameras.push_back({.eye_world = centre + 100 * along,
                       .target_world = centre,
                       .up = axis,
                       .fov_y_degrees = 25});
    for (const Filter filter : {Filter::BSpline, Filter::Interpolating}) {
        const Verdict v =
            judge({.name = "torus edge-on", .samples = control, .filter = filter}, cameras, 48);
        EXPECT_GT(v.certain, 3000);
    }
}

TEST_F(Certified, NothingIsMissedOfWhiteNoise) {
    Random random(5);
    const auto field =
        std::make_shared<DenseField>(random_dense(random, {Index3::Zero(), Index3::Constant(24)}));
    for (const Filter filter :
         {Filter::Linear, Filter::BSpline, Filter::Interpolating, Filter::CatmullRom}) {
        const Verdict v = judge({.name = "white noise", .samples = field, .filter = filter},
                                oblique_cameras(24, 5, 2));
        EXPECT_GT(v.certain, 1000);
    }
}

TEST_F(Certified, RaysThatEnterTheFieldInsideTheObjectSeeNoSurfaceThere) {
    // Rounding once put the place where they enter into a block beyond the field, whose sign was
    // that of its page's first sample.
    for (unsigned seed = 11; seed <= 14; ++seed) {
        const Verdict v = judge(subject_of(smooth_noise(40, seed)), oblique_cameras(40, seed, 2));
        EXPECT_GT(v.certain, 3000);
    }
}

TEST_F(Certified, NothingIsMissedByTheOtherFilters) {
    constexpr int n = 32;
    for (const HardField& field : hard_fields(n, 6)) {
        for (const Filter filter :
             {Filter::Linear, Filter::CatmullRom, Filter::Interpolating, Filter::Exact}) {
            std::vector<Camera> cameras = oblique_cameras(n, 6, 2);
            cameras.push_back(axis_cameras(n)[0]);
            judge(subject_of(field, filter), cameras);
        }
    }
}

TEST_F(Certified, NothingIsMissedByLinearFetches) {
    // With fractions of 8 bits, as hardware filters have.
    constexpr int n = 32;
    for (const HardField& field : hard_fields(n, 12)) {
        for (const Filter filter : {Filter::Linear, Filter::BSpline}) {
            std::vector<Camera> cameras = oblique_cameras(n, 12, 2);
            cameras.push_back(axis_cameras(n)[1]);
            Subject subject = subject_of(field, filter);
            subject.storage = {.fetch = Fetch::Linear, .fraction_bits = 8};
            const Verdict v = judge(subject, cameras);
            EXPECT_GT(v.certain, 500) << field.name;
        }
    }
}

TEST_F(Certified, EyesInsideTheObjectAndInsideActiveBlocks) {
    constexpr int n = 32;
    for (const HardField& field : hard_fields(n, 7)) {
        Random random(7);
        const Subject subject = subject_of(field);
        const ReferenceCaster caster(*field.control, 0, {.step_voxels = reference_step});
        std::vector<Camera> cameras;
        while (cameras.size() < 8) {
            const Ray ray = random_ray(random, n);
            const auto t = caster.hit(ray);
            if (!t) continue;
            // Before the surface, and as deep behind it as the thinnest part allows; a tenth of it,
            // or a thousandth of a voxel, so that the start's side is certain.
            const double half = std::clamp(field.thickness_voxels / 2, 0.0, 1.0);
            const double offset = cameras.size() % 4 == 0   ? -1.7
                                  : cameras.size() % 4 == 1 ? -0.05
                                  : half > 0                ? half
                                                            : 0.5;
            const Vec3d eye = ray.origin_world + (*t + offset) * ray.direction_world;
            Camera camera{.eye_world = eye,
                          .target_world = eye + random_point(random, -1, 1),
                          .up = random_point(random, -1, 1),
                          .fov_y_degrees = 120};
            if (cameras.size() % 2 == 1) camera.target_world = eye + ray.direction_world;
            cameras.push_back(camera);
        }
        const Verdict v = judge(subject, cameras, 32);
        EXPECT_GT(v.certain, 500) << field.name;
    }
}

TEST_F(Certified, PlateausAtTheIsoValueShowWhatIsNegativeOnly) {
    for (const double iso : {0.0, 0.375}) {
        const auto plateau = [&](auto value) {
            return control_of(24, [&](const Vec3d& p) { return iso + value(p); });
        };
        for (const Filter filter :
             {Filter::Linear, Filter::BSpline, Filter::Interpolating, Filter::CatmullRom}) {
            std::vector<Camera> cameras = oblique_cameras(24, 8, 2);
            cameras.push_back(axis_cameras(24)[2]);
            cameras.push_back({.eye_world = {11.3, 12.1, 17.5}, .target_world = {11, 12, 5}});
            const Subject flat{.name = "flat",
                               .samples = plateau([](const Vec3d&) { return 0.0; }),
                               .filter = filter,
                               .iso = iso};
            load(flat);
            for (const Camera& camera : cameras) {
                for (const float value : draw(camera, 32).rgba) ASSERT_EQ(value, 0);
            }
            // Nowhere negative. Catmull-Rom and the interpolating control samples undershoot beside
            // a kink, which is then a surface.
            const Subject above{.name = "flat and above",
                                .samples = plateau([](const Vec3d& p) {
                                    return std::max(0.0, (p.z() - 12.0) / 4);
                                }),
                                .filter = filter,
                                .iso = iso};
            load(above);
            const bool undershoots =
                filter == Filter::CatmullRom || filter == Filter::Interpolating;
            if (!undershoots) {
                for (const Camera& camera : cameras) {
                    for (const float value : draw(camera, 32).rgba) ASSERT_EQ(value, 0);
                }
            }
            judge(above, cameras, 32);
            // Negative below z = 12, from there on flat.
            const Verdict v = judge({.name = "flat and below",
                                     .samples = plateau([](const Vec3d& p) {
                                         return std::min(0.0, (p.z() - 12.0) / 4);
                                     }),
                                     .filter = filter,
                                     .iso = iso},
                                    cameras, 32);
            EXPECT_GT(v.hits, 500) << filter_name(filter);
        }
    }
}

TEST_F(Certified, RaysInTheFacesBetweenBlocksMeetTheNearestSurfaceFirst) {
    // A slab over the plane where the ray's parameter is zero, which once split rays that run in a
    // face: the half behind it was in the upper block and came first.
    for (int axis = 0; axis < 3; ++axis) {
        const auto control =
            control_of(48, [&](const Vec3d& p) { return std::abs(p[axis] - 29.6) - 5; });
        for (const double sign : {-1.0, 1.0}) {
            for (const Projection projection :
                 {Projection::Perspective, Projection::Orthographic}) {
                // One pixel: zero components are exact. Faces along both other axes, or along one.
                for (const double offset : {0.0, 3.0}) {
                    Vec3d middle = Vec3d::Constant(16);
                    middle[(axis + 1) % 3] += offset;
                    const Camera camera{.eye_world = middle + 64 * sign * Vec3d::Unit(axis),
                                        .target_world = middle,
                                        .up = Vec3d::Unit((axis + 1) % 3),
                                        .projection = projection,
                                        .height_world = 1};
                    const Verdict v = judge({.name = "slab", .samples = control}, {camera}, 1);
                    EXPECT_EQ(v.hits, 1);
                }
            }
        }
    }
}

/// Expects the same bits. Returns how many pixels hit.
int expect_identical(const Image& a, const Image& b) {
    int hits = 0;
    int different = 0;
    double greatest = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i) {
        different += a.rgba[i] != b.rgba[i];
        greatest = std::max(greatest, double(std::abs(a.rgba[i] - b.rgba[i])));
        hits += i % 4 == 3 && a.rgba[i] != 0;
    }
    EXPECT_EQ(different, 0) << "by up to " << greatest;
    return hits;
}

TEST_F(Certified, PicturesDoNotDependOnHowSamplesAreStored) {
    constexpr int n = 40;
    for (const HardField& field : {tilted_torus(n, 9), smooth_noise(n, 9)}) {
        for (const Filter filter : {Filter::Linear, Filter::Interpolating, Filter::CatmullRom}) {
            for (const SampleFormat format :
                 {SampleFormat::Float32, SampleFormat::Float16, SampleFormat::Norm16}) {
                for (const Camera& camera : oblique_cameras(n, 9, 2)) {
                    Subject subject = subject_of(field, filter);
                    subject.storage.format = format;
                    load(subject);
                    const Image expected = draw(camera, 48);
                    for (const Fetch fetch : {Fetch::Rows, Fetch::Samples}) {
                        for (const int brick_size : {8, 16, 32}) {
                            subject.storage = {fetch, format, brick_size};
                            load(subject);
                            SCOPED_TRACE(std::string(filter_name(filter)) + " " + field.name +
                                         ", fetch " + std::to_string(int(fetch)) + ", format " +
                                         std::to_string(int(format)) + ", bricks of " +
                                         std::to_string(brick_size));
                            EXPECT_GT(expect_identical(draw(camera, 48), expected), 100);
                        }
                    }
                }
            }
        }
    }
}

TEST_F(Certified, PicturesDoNotDependOnTheNumberOfThreads) {
    const Subject subject = subject_of(smooth_noise(48, 10), Filter::Interpolating);
    const Camera camera = oblique_cameras(48, 10, 1)[0];
    const auto picture = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        load(subject);
        return draw(camera, 96);
    };
    EXPECT_GT(expect_identical(picture(1), picture(2)), 1000);
}

TEST_F(Certified, StorageInSixteenBitsErrsByWhatItSays) {
    constexpr int n = 40;
    for (const HardField& field : {tilted_torus(n, 11), smooth_noise(n, 11)}) {
        for (const Filter filter : {Filter::Linear, Filter::Interpolating, Filter::CatmullRom}) {
            for (const SampleFormat format : {SampleFormat::Float16, SampleFormat::Norm16}) {
                Subject subject = subject_of(field, filter);
                subject.storage.format = format;
                const auto control = control_samples(subject.samples, filter);
                const BlockRanges ranges = find_block_ranges(*control, subject.kernel());
                const FieldOnGpu on_gpu(*subject.samples, *control, subject.kernel(), ranges,
                                        active_pages(ranges, 0), 0, subject.storage, {});
                subject.storage_error = on_gpu.pool().storage_error();
                // 2^-11 of the greatest value, and a step of 2^-15 halved.
                EXPECT_GT(subject.storage_error, 0);
                EXPECT_LT(subject.storage_error, 0x1p-10 * on_gpu.pool().greatest_value());
                const Verdict v = judge(subject, oblique_cameras(n, 11, 2));
                EXPECT_GT(v.certain, 1000);
            }
        }
    }
}

} // namespace
} // namespace isocast
