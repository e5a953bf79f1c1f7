// The image of curvatures against the double twin and against shapes.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/curvature.h"

#include "../volume/random_fields.h"
#include "filtering/filter.h"
#include "filtering/reconstruct.h"
#include "raycaster/renderer.h"

#include <gtest/gtest.h>

#include <cmath>

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
    std::unique_ptr<gl::Context> context = gl::make_context({.backend = gl::Backend::Osmesa});
    Renderer renderer{*context, shader_folder};
    ImageSet wanted{FrameImage::Hit, FrameImage::Curvature};
    Image hits;
    Image curvatures;

    FrameReport draw(const Scene& scene, const Camera& camera) {
        renderer.load(scene);
        const FrameReport report = renderer.draw(camera, 64, 64, wanted);
        hits = renderer.read(FrameImage::Hit);
        curvatures = renderer.read(FrameImage::Curvature);
        return report;
    }
    /// Calls visit(p_world, curvature pixel) at every hit; returns how many there are.
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
    wanted.insert({FrameImage::ViewCurvature, FrameImage::FlowLineCurvature});
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
    wanted.insert({FrameImage::ViewCurvature, FrameImage::FlowLineCurvature});
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
    const FrameReport report =
        draw({.field = sampled_in(GridSpace::uniform(1), torus)}, torus_camera);
    for (const PassReport& pass : report.passes)
        EXPECT_EQ(pass.ran, pass.name == "raycast" || pass.name == "curvature") << pass.name;
    EXPECT_EQ(report.programs_compiled, 2);
    EXPECT_EQ(report.image_bytes, 2 * 64 * 64 * 16);
}

} // namespace
} // namespace isocast
