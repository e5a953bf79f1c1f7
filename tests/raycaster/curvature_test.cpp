// The images of curvatures and their directions against the double twin and against shapes.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/curvature.h"

#include "../volume/random_fields.h"
#include "filtering/filter.h"
#include "filtering/reconstruct.h"
#include "filtering/smoothed_field.h"
#include "gl/errors.h"
#include "raycaster/passes.h"
#include "raycaster/renderer.h"
#include "test_context.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

namespace isocast {
namespace {

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";
constexpr int n = 40;

/// Samples of a world-space field at n^3 points of a grid.
std::shared_ptr<const FieldSource> sampled_in(const GridSpace& space, const AnalyticField& field) {
    const IndexBox extent{Index3::Zero(), Index3::Constant(n)};
    std::vector<float> values;
    test::for_each_sample(extent, [&](const Index3& i) {
        values.push_back(static_cast<float>(field.jet(space.to_world(i.cast<double>())).value));
    });
    return std::make_shared<DenseField>(space, extent, std::move(values));
}

struct CurvatureImages : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, shader_folder};
    ImageSet also_wanted;
    Image hits;
    Image curvatures; // or directions

    FrameReport draw(const Scene& scene, const Camera& camera,
                     FrameImage image = FrameImage::Curvature) {
        renderer.load(scene);
        ImageSet all{FrameImage::Hit, image};
        all.insert(also_wanted);
        const FrameReport report = renderer.draw(camera, 64, 64, all);
        hits = renderer.read(FrameImage::Hit);
        curvatures = renderer.read(image);
        return report;
    }
    /// Calls visit(p_world, pixel) at every hit; returns how many there are.
    template<class Visit>
    int for_each_hit(const Camera& camera, Visit visit) const {
        int count = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            if (hits.rgba[i + 3] == 0) {
                EXPECT_EQ(curvatures.rgba[i + 3], 0);
                continue;
            }
            ++count;
            visit(Vec3d(camera.eye_world + Vec3d(hits.rgba[i], hits.rgba[i + 1], hits.rgba[i + 2])),
                  &curvatures.rgba[i]);
        }
        return count;
    }
};

const AnalyticField torus = torus_field(Vec3d(19.6, 20.1, 19.3), {0.3, 1, 0.5}, 11, 4.5);
const Camera torus_camera{.eye_world = {60, 50, 110}, .target_world = {20, 20, 20}};

TEST_F(CurvatureImages, AreTheTwins) {
    also_wanted.insert({FrameImage::ViewCurvature, FrameImage::FlowLineCurvature});
    const auto field = sampled_in(GridSpace::uniform(1), torus);
    for (const Filter filter : {Filter::Interpolating, Filter::BSpline, Filter::CatmullRom}) {
        for (const Fetch fetch : {Fetch::Rows, Fetch::Samples}) {
            draw({.field = field, .filter = filter, .storage = {.fetch = fetch}}, torus_camera);
            const Image view_curvatures = renderer.read(FrameImage::ViewCurvature);
            const Image flow_line_curvatures = renderer.read(FrameImage::FlowLineCurvature);
            const auto control = control_samples(field, filter);
            double worst = 0;
            const int count = for_each_hit(torus_camera, [&](const Vec3d& p, const float* k) {
                // Catmull-Rom's second derivatives jump between cells; 1e-4: as far as coordinates
                // round.
                if (filter == Filter::CatmullRom &&
                    (p.array() - p.array().round()).abs().minCoeff() < 1e-4)
                    return;
                const Jet jet = kernel_jet(*control, p, kernel_of(filter));
                const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
                worst = std::max({worst, std::abs(k[0] - c.k1), std::abs(k[1] - c.k2)});
                EXPECT_EQ(k[3], 1);
                const auto pixel = static_cast<std::size_t>(k - curvatures.rgba.data());
                const double view = view_curvatures.rgba[pixel];
                const double flow = flow_line_curvatures.rgba[pixel];
                worst = std::max({worst,
                                  std::abs(view - normal_curvature(jet.gradient, jet.hessian,
                                                                   p - torus_camera.eye_world)),
                                  std::abs(flow - flow_line_curvature(jet.gradient, jet.hessian))});
            });
            EXPECT_GT(count, 500);
            // Samples that a hit reads are at most 5 in size; 32 roundings of sums whose |weights|
            // are at most 4 (an axis' second derivative) times 1.25^2: 6e-5 at a gradient of one.
            // Hits are rounded by 8e-6, times third derivatives of at most 2/4.5^2.
            EXPECT_LT(worst, 1e-4) << filter_name(filter);
        }
    }
}

TEST_F(CurvatureImages, OfTheTorusAreItsOwn) {
    draw({.field = sampled_in(GridSpace::uniform(1), torus)}, torus_camera);
    for_each_hit(torus_camera, [&](const Vec3d& p, const float* k) {
        const Jet jet = torus.jet(p);
        const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
        // Hessians of the interpolating spline err to second order: by (1/12) of fourth
        // derivatives, at most 15/4.5^3 for a circle of 4.5 voxels.
        EXPECT_NEAR(k[0], c.k1, 0.0137);
        EXPECT_NEAR(k[1], c.k2, 0.0137);
    });
}

TEST_F(CurvatureImages, OfASphereDoNotDependOnTheShapeOfVoxels) {
    std::vector<GridSpace> spaces(3, GridSpace::uniform(0.05));
    spaces[1].world_from_index.linear() = 0.05 * Vec3d(1.3, 0.8, 1).asDiagonal();
    spaces[2].world_from_index.linear() << 0, 0.055, 0, 0.05, 0.01, 0, 0.01, 0,
        0.045; // left-handed
    for (GridSpace& space : spaces) {
        space.world_from_index.translation() = Vec3d(100, -50, 20);
        const Vec3d middle = space.to_world(Vec3d(19.6, 20.1, 19.3));
        constexpr double radius = 0.5;
        const Camera camera{.eye_world = middle + Vec3d(1.2, 1.5, 3), .target_world = middle};
        draw({.field = sampled_in(space, sphere_field(middle, radius))}, camera);
        const int count = for_each_hit(camera, [&](const Vec3d&, const float* k) {
            // A radius of 8 voxels at least; second derivatives err by 15/12/8^3 of one there.
            EXPECT_NEAR(k[0] * radius, 1, 0.02);
            EXPECT_NEAR(k[1] * radius, 1, 0.02);
            EXPECT_GE(k[0], k[1]);
        });
        EXPECT_GT(count, 500);
    }
}

TEST_F(CurvatureImages, HaveTheTwinsDirections) {
    GridSpace turned;
    turned.world_from_index.linear() << 0, 1.1, 0, 1, 0.2, 0, 0.2, 0, 0.9; // left-handed
    for (const GridSpace& space : {GridSpace::uniform(1), turned}) {
        const auto field = sampled_in(space, torus);
        const Filter filter = Filter::Interpolating;
        draw({.field = field}, torus_camera, FrameImage::Direction);
        const auto control = control_samples(field, filter);
        const int count = for_each_hit(torus_camera, [&](const Vec3d& p, const float* d) {
            const Jet jet = kernel_jet(*control, space.to_index(p), kernel_of(filter));
            const Curvatures c = principal_curvatures(space.gradient_to_world(jet.gradient),
                                                      space.hessian_to_world(jet.hessian));
            const Vec3d direction(d[0], d[1], d[2]);
            // Entries that err by e turn directions by up to 2 e / (k1 - k2); curvatures err by
            // 1e-4 (AreTheTwins), half as much again where voxels are 0.9 wide and sheared.
            EXPECT_LT(direction.cross(c.direction1).norm(), 2 * 1.5e-4 / (c.k1 - c.k2));
            EXPECT_NEAR(direction.norm(), 1, 1e-6);
            // Less 6 * 3 times 4 * 2^-19 of samples up to 5, for stretches up to 1.2.
            const double differ = (c.k1 - c.k2) / (std::abs(c.k1) + std::abs(c.k2));
            EXPECT_LE(d[3], differ + 0.001);
            EXPECT_GE(d[3], differ - 0.01);
        });
        EXPECT_GT(count, 500);
    }
}

TEST_F(CurvatureImages, HaveDirectionsAlongTheTorussMeridians) {
    draw({.field = sampled_in(GridSpace::uniform(1), torus)}, torus_camera, FrameImage::Direction);
    for_each_hit(torus_camera, [&](const Vec3d& p, const float* d) {
        const Jet jet = torus.jet(p);
        const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
        // Entries err as curvatures do (OfTheTorusAreItsOwn).
        EXPECT_LT(Vec3d(d[0], d[1], d[2]).cross(c.direction1).norm(), 0.0137 / (c.k1 - c.k2));
    });
}

/// Any quadratic function is its own spline: what is left of k1 - k2 on this sphere are roundings.
TEST_F(CurvatureImages, AreFlaggedAtUmbilicsAndOnlyThere) {
    const Vec3d middle(19.6, 20.1, 19.3);
    const auto quadric = [&](const Vec3d& axes) {
        return AnalyticField{"quadric", [=](const Vec3d& p) {
                                 const Vec3d q = (p - middle).cwiseQuotient(axes);
                                 return Jet{(q.squaredNorm() - 1) * axes.minCoeff() / 2};
                             }};
    };
    const auto sphere = sampled_in(GridSpace::uniform(1), quadric(Vec3d::Constant(12)));
    for (const SampleFormat format : {SampleFormat::Float32, SampleFormat::Float16}) {
        draw({.field = sphere, .storage = {.format = format}}, torus_camera);
        EXPECT_GT(
            for_each_hit(torus_camera, [](const Vec3d&, const float* k) { EXPECT_EQ(k[3], 3); }),
            500);
        draw({.field = sphere, .storage = {.format = format}}, torus_camera, FrameImage::Direction);
        for_each_hit(torus_camera, [](const Vec3d&, const float* d) {
            EXPECT_EQ(d[3], 0);
            EXPECT_NEAR(Vec3d(d[0], d[1], d[2]).norm(), 1, 1e-6);
        });
    }

    // An ellipsoid has four umbilics, in the plane of its longest and shortest axis a and c, at
    // x^2 = a^2 (a^2 - b^2)/(a^2 - c^2).
    const Vec3d axes(14, 11, 8);
    draw({.field = sampled_in(GridSpace::uniform(1), quadric(axes))}, torus_camera);
    const Vec3d squares = axes.array().square();
    const Vec3d umbilic(
        std::sqrt(squares.x() * (squares.x() - squares.y()) / (squares.x() - squares.z())), 0,
        std::sqrt(squares.z() * (squares.y() - squares.z()) / (squares.x() - squares.z())));
    double nearest = 1e9;
    for_each_hit(torus_camera, [&](const Vec3d& p, const float* k) {
        const Vec3d q = (p - middle).cwiseAbs();
        const double distance = (q - umbilic).norm();
        nearest = std::min(nearest, distance);
        // k1 - k2 grows by more than 1/14^2 a voxel around an umbilic; 6 * 3 * 4 * 2^-19 of samples
        // up to 6, by gradients of at least 8/14, are 1.4e-3.
        if (distance > 0.3) {
            EXPECT_EQ(k[3], 1) << distance;
        }
        if (distance < 0.01) {
            EXPECT_EQ(k[3], 3) << distance;
        }
        // k1 - k2 there is less than what it grows by, 1/8^2 a voxel at most.
        if (distance < 1) {
            EXPECT_LT(k[0] - k[1], distance / 16);
        }
    });
    EXPECT_LT(nearest, 0.5); // pixels are as wide
}

/// (x - 20)^3 is its own spline; the gradient vanishes on all of its surface.
TEST_F(CurvatureImages, AreFlaggedAndZeroWhereTheGradientVanishes) {
    const AnalyticField cubic{
        "cubic", [](const Vec3d& p) { return Jet{std::pow((p.x() + p.y() - 40.5) / 2, 3)}; }};
    const auto field = sampled_in(GridSpace::uniform(1), cubic);
    for (const FrameImage image : {FrameImage::Curvature, FrameImage::Direction}) {
        draw({.field = field}, torus_camera, image);
        const int count = for_each_hit(torus_camera, [&](const Vec3d& p, const float* pixel) {
            if (p.minCoeff() < 3 || p.maxCoeff() > n - 4) return; // the border's samples go on
            const float flag = image == FrameImage::Curvature ? 2 : 0;
            EXPECT_EQ(std::vector<float>(pixel, pixel + 4), (std::vector<float>{0, 0, 0, flag}));
        });
        EXPECT_GT(count, 500);
    }
}

TEST_F(CurvatureImages, AreFiniteOnNoise) {
    test::Random random(5);
    const auto noise = std::make_shared<DenseField>(
        test::random_dense(random, {Index3::Zero(), Index3::Constant(n)}));
    for (const Filter filter : {Filter::Interpolating, Filter::CatmullRom, Filter::Linear}) {
        draw({.field = noise, .filter = filter}, torus_camera);
        const int count = for_each_hit(torus_camera, [&](const Vec3d&, const float* k) {
            EXPECT_TRUE(std::isfinite(k[0]) && std::isfinite(k[1]));
            EXPECT_GE(k[0], k[1]);
        });
        EXPECT_GT(count, 500);
    }
}

TEST_F(CurvatureImages, AreTheSameHoweverFewBricksFit) {
    also_wanted.insert({FrameImage::ViewCurvature, FrameImage::FlowLineCurvature});
    const auto field = sampled_in(GridSpace::uniform(1), torus);
    draw({.field = field}, torus_camera);
    const Image all = curvatures;
    const Image view = renderer.read(FrameImage::ViewCurvature);
    const Image flow = renderer.read(FrameImage::FlowLineCurvature);
    draw({.field = field,
          .storage = {.budget_bytes = 5 * BrickLayout(StorageOptions{}).brick_bytes}},
         torus_camera);
    EXPECT_EQ(curvatures.rgba, all.rgba);
    EXPECT_EQ(renderer.read(FrameImage::ViewCurvature).rgba, view.rgba);
    EXPECT_EQ(renderer.read(FrameImage::FlowLineCurvature).rgba, flow.rgba);
}

TEST_F(CurvatureImages, AreTheSameInAnyCompany) {
    const std::array images{FrameImage::Curvature, FrameImage::ViewCurvature,
                            FrameImage::FlowLineCurvature};
    renderer.load({.field = sampled_in(GridSpace::uniform(1), torus)});
    std::array<Image, 3> alone;
    for (std::size_t i = 0; i < 3; ++i) {
        const FrameReport report = renderer.draw(torus_camera, 64, 64, {images[i]});
        alone[i] = renderer.read(images[i]);
        // Hits, and two principal curvatures or one.
        EXPECT_EQ(report.image_bytes, 64 * 64 * (16 + (i == 0 ? 16 : 4)));
    }
    for (std::size_t without = 0; without < 4; ++without) {
        ImageSet some;
        for (std::size_t i = 0; i < 3; ++i)
            if (i != without) some.insert(images[i]);
        const FrameReport report = renderer.draw(torus_camera, 64, 64, some);
        int drawn = 0;
        for (std::size_t i = 0; i < 3; ++i)
            if (i != without) {
                EXPECT_EQ(renderer.read(images[i]).rgba, alone[i].rgba);
            }
        for (const PassReport& pass : report.passes) drawn += pass.ran && pass.drawn_by.empty();
        EXPECT_EQ(drawn, 2); // hits, and all that follows from the Hessian
    }
}

TEST_F(CurvatureImages, AloneRunNoOtherPass) {
    for (const FrameImage image : {FrameImage::Curvature, FrameImage::Direction}) {
        Renderer fresh(*context, shader_folder);
        fresh.load({.field = sampled_in(GridSpace::uniform(1), torus)});
        const FrameReport report = fresh.draw(torus_camera, 64, 64, {image});
        const std::string_view own = image == FrameImage::Curvature ? "curvature" : "direction";
        for (const PassReport& pass : report.passes)
            EXPECT_EQ(pass.ran, pass.name == "raycast" || pass.name == own) << pass.name;
        EXPECT_EQ(report.programs_compiled, 2);
        EXPECT_EQ(report.image_bytes, 2 * 64 * 64 * 16);
    }
}

/// With a library of directions that no compiler takes, only the program of directions fails.
TEST_F(CurvatureImages, HaveNoDirectionsInTheirProgram) {
    const std::filesystem::path root = testing::TempDir() + "no_directions";
    std::filesystem::create_directories(root / "filtering");
    std::ofstream(root / "filtering/principal_direction.glsl") << "#error directions\n";
    gl::ShaderLibrary shaders({root, shader_folder});
    std::array<int, 2> counts{};
    for (const gl::ProgramKey& key : all_programs()) {
        if (key.entry_points.back() != "raycast/derivatives.frag" ||
            key.defines.at("KERNEL") != "1" || key.defines.at("FETCH") != "0" ||
            key.defines.at("IS_STREAMED") != "0")
            continue;
        const auto place = key.defines.find("DIRECTION_AT"); // -1: not asked for
        const bool has_directions = place != key.defines.end() && place->second != "-1";
        ++counts[has_directions ? 1 : 0];
        if (has_directions)
            EXPECT_THROW(shaders.program(key), gl::GlError);
        else
            EXPECT_NO_THROW(shaders.program(key));
    }
    EXPECT_GT(counts[0], 0);
    EXPECT_GT(counts[1], 0);
    std::filesystem::remove_all(root);
}

using CurvatureScale = CurvatureImages;

TEST_F(CurvatureScale, MovesNeitherHitsNorNormals) {
    test::Random random(3);
    const auto noise = std::make_shared<DenseField>(
        test::random_dense(random, {Index3::Zero(), Index3::Constant(n)}));
    const auto pictures = [&](double scale) {
        renderer.load({.field = noise, .curvature_scale_voxels = scale});
        renderer.draw(torus_camera, 64, 64,
                      {FrameImage::Hit, FrameImage::Gradient, FrameImage::Curvature});
        return std::array{renderer.read(FrameImage::Hit).rgba,
                          renderer.read(FrameImage::Gradient).rgba,
                          renderer.read(FrameImage::Curvature).rgba};
    };
    const auto plain = pictures(0);
    const auto smooth = pictures(1.5);
    EXPECT_EQ(smooth[0], plain[0]);
    EXPECT_EQ(smooth[1], plain[1]);
    EXPECT_NE(smooth[2], plain[2]);
}

TEST_F(CurvatureScale, TakesMemoryWhileCurvaturesAreAskedForAndNoLonger) {
    const auto field = sampled_in(GridSpace::uniform(1), torus);
    const auto bytes = [&](const ImageSet& wanted) {
        return renderer.draw(torus_camera, 64, 64, wanted).field_bytes;
    };
    renderer.load({.field = field});
    const std::int64_t plain = bytes({FrameImage::Curvature});
    renderer.load({.field = field, .curvature_scale_voxels = 2});
    EXPECT_EQ(bytes({FrameImage::Beauty, FrameImage::Gradient}), plain);
    EXPECT_EQ(bytes({FrameImage::Curvature}), 2 * plain);
    EXPECT_EQ(bytes({FrameImage::Direction}), 2 * plain);
    EXPECT_EQ(bytes({FrameImage::Gradient}), plain);
    // A scale needs no program of its own.
    EXPECT_EQ(renderer.draw(torus_camera, 64, 64, {FrameImage::Curvature}).programs_compiled, [&] {
        Renderer other(*context, shader_folder);
        other.load({.field = field});
        for (const FrameImage image :
             {FrameImage::Beauty, FrameImage::Curvature, FrameImage::Direction})
            other.draw(torus_camera, 64, 64, {image});
        return other.draw(torus_camera, 64, 64, {FrameImage::Hit}).programs_compiled;
    }());
}

TEST_F(CurvatureScale, FollowsTheIsoValueAndFewBricks) {
    const auto field = sampled_in(GridSpace::uniform(1), torus);
    draw({.field = field, .iso_world = 0.5, .curvature_scale_voxels = 1}, torus_camera);
    const Image expected = curvatures;
    draw({.field = field,
          .curvature_scale_voxels = 1,
          .storage = {.budget_bytes = 2 * 5 * BrickLayout(StorageOptions{}).brick_bytes}},
         torus_camera);
    renderer.set_iso(0.5);
    renderer.draw(torus_camera, 64, 64, {FrameImage::Curvature});
    EXPECT_EQ(renderer.read(FrameImage::Curvature).rgba, expected.rgba);
}

TEST_F(CurvatureScale, GivesTheTwinsCurvatures) {
    const auto field = sampled_in(GridSpace::uniform(1), torus);
    draw({.field = field, .curvature_scale_voxels = 1.5}, torus_camera);
    const auto control =
        control_samples(std::make_shared<SmoothedField>(field, 1.5), Filter::Interpolating);
    const int count = for_each_hit(torus_camera, [&](const Vec3d& p, const float* k) {
        const Jet jet = tricubic_jet(*control, p);
        const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
        EXPECT_NEAR(k[0], c.k1, 1e-4); // AreTheTwins
        EXPECT_NEAR(k[1], c.k2, 1e-4);
    });
    EXPECT_GT(count, 500);
}

/// White noise of deviation s makes second derivatives of the field, smoothed by a Gaussian of
/// scale t, vary by s^2 times the integral of k_u^4 exp(-t^2 k^2) over (2 pi)^3: 3 a / 4 t^4 with
/// a = s^2 / (8 pi^(3/2) t^3); those along u and v vary together by a / 4 t^4, so that the mean
/// curvature of a field of slope one varies by a / 2 t^4.
TEST_F(CurvatureScale, LeavesOfNoiseWhatAGaussianLeaves) {
    test::Random random(8);
    const Vec3d middle = Vec3d::Constant(19.5);
    constexpr double radius = 13;
    constexpr double deviation = 0.05;
    std::normal_distribution<double> normal(0, deviation);
    const auto field = sampled_in(GridSpace::uniform(1),
                                  {"noisy sphere", [&](const Vec3d& p) {
                                       return Jet{(p - middle).norm() - radius + normal(random)};
                                   }});
    const auto deviation_of_mean = [&](double scale) {
        double squares = 0;
        int count = 0;
        for (const Vec3d& side : {Vec3d(1, 0, 0), Vec3d(-1, 0, 0), Vec3d(0, 1, 0.01),
                                  Vec3d(0, -1, 0.01), Vec3d(0, 0, 1), Vec3d(0, 0, -1)}) {
            const Camera camera{.eye_world = middle + 90 * side,
                                .target_world = middle,
                                .fov_y_degrees = 10}; // its middle: 0.6 of the radius
            draw({.field = field, .curvature_scale_voxels = scale}, camera);
            count += for_each_hit(camera, [&](const Vec3d& p, const float* k) {
                squares += std::pow((k[0] + k[1]) / 2 - 1 / (p - middle).norm(), 2);
            });
        }
        EXPECT_GT(count, 6 * 3000);
        return std::sqrt(squares / count);
    };
    for (const double scale : {1.5, 2.0}) {
        const double expected =
            deviation * std::sqrt(1 / (16 * std::pow(std::numbers::pi, 1.5) * std::pow(scale, 7)));
        // Some 150 independent places: 6 %, three times that.
        EXPECT_NEAR(deviation_of_mean(scale) / expected, 1, 0.2) << scale;
    }
    EXPECT_GT(deviation_of_mean(0), 10 * deviation_of_mean(1.5));
}

TEST_F(CurvatureScale, OutOfRangeOrWithCoarseBricksIsRefused) {
    const auto field = sampled_in(GridSpace::uniform(1), torus);
    for (const double scale : {-1.0, 100.0, std::nan("")})
        EXPECT_THROW(renderer.load({.field = field, .curvature_scale_voxels = scale}), InputError);
    EXPECT_THROW(renderer.load({.field = field,
                                .curvature_scale_voxels = 1,
                                .storage = {.over_budget = OverBudget::Coarsen}}),
                 InputError);
}

} // namespace
} // namespace isocast
