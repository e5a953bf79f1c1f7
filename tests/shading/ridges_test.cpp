// Ridges and valleys against the curvatures that surfaces have.
// SPDX-License-Identifier: MPL-2.0
#include "effect_rules.h"

#include "filtering/curvature.h"

namespace isocast::test {
namespace {

struct RidgeLines : Shading {
    /// Calls visit(p_world, pixel of the ridges) at every hit; returns how many there are.
    template<class Visit>
    int for_each_hit(Visit visit) const {
        const Image hits = renderer.read(FrameImage::Hit);
        const Image ridges = renderer.read(FrameImage::Ridges);
        int count = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            const float* hit = &hits.rgba[i];
            if (hit[3] == 0) {
                EXPECT_EQ(ridges.rgba[i + 3], 0);
                continue;
            }
            ++count;
            visit(Vec3d(camera.eye_world + Vec3d(hit[0], hit[1], hit[2])), &ridges.rgba[i]);
        }
        return count;
    }
};

double smoothstep(double lo, double hi, double x) {
    const double t = std::clamp((x - lo) / (hi - lo), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

TEST_F(RidgeLines, AreTheDomainOfTheCurvatures) {
    for (const std::string_view name : {"torus", "cube"}) {
        const AnalyticField field = builtin_field(name);
        constexpr double threshold = 1.5;
        Scene scene{.field = sampled(field, 64)};
        scene.look.effects.ridges.threshold = threshold;
        draw(scene, FrameImage::Ridges);
        int ridges = 0;
        const int count = for_each_hit([&](const Vec3d& p, const float* pixel) {
            const Jet jet = field.jet(p);
            const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
            const double measure = std::max(c.k1 - std::abs(c.k2), -c.k2 - std::abs(c.k1));
            // The ramp rises by 3/threshold at most; curvatures of 64 samples err by 1 % of the
            // greatest, which is 3, twice in a difference.
            EXPECT_NEAR(pixel[3], smoothstep(0.75 * threshold, 1.25 * threshold, measure),
                        3 / threshold * 2 * 0.01 * 3)
                << name << " " << p.transpose();
            ridges += pixel[3] > 0.5;
        });
        EXPECT_GT(ridges, 200) << name;
        EXPECT_LT(ridges, count - 200) << name;
    }
}

TEST_F(RidgeLines, AreValleysOfTheFieldTurnedInsideOut) {
    AnalyticField cube = builtin_field("cube");
    Scene scene{.field = sampled(cube, 48)};
    scene.look.effects.ridges.threshold = 1.5;
    const Image ridges = draw(scene, FrameImage::Ridges);
    const AnalyticField turned{"turned",
                               [cube](const Vec3d& p) {
                                   Jet jet = cube.jet(p);
                                   jet.value = -jet.value;
                                   return jet;
                               },
                               cube.half_extent_world};
    scene.field = sampled(turned, 48);
    const Image valleys = draw(scene, FrameImage::Ridges);
    const Ridges look;
    int lines = 0;
    for (std::size_t i = 0; i < ridges.rgba.size(); i += 4) {
        // Hits differ by the search's accuracy, a hundredth of a voxel at a grazing ray.
        EXPECT_NEAR(ridges.rgba[i + 3], valleys.rgba[i + 3], 0.01);
        if (ridges.rgba[i + 3] < 0.5) continue;
        ++lines;
        EXPECT_EQ(ridges.rgba[i], float(look.ridge_colour.x()));
        EXPECT_EQ(valleys.rgba[i], float(look.valley_colour.x()));
    }
    EXPECT_GT(lines, 200);
}

TEST_F(RidgeLines, OfASphereAreNone) {
    draw({.field = sampled(builtin_field("sphere"), 48)}, FrameImage::Ridges);
    EXPECT_GT(for_each_hit([&](const Vec3d&, const float* pixel) { EXPECT_EQ(pixel[3], 0); }), 500);
}

TEST_F(RidgeLines, OfAPlaneAreNone) {
    const AnalyticField plane{
        "plane", [](const Vec3d& p) { return Jet{.value = Vec3d(1, 2, 3).normalized().dot(p)}; },
        1};
    draw({.field = sampled(plane, 32)}, FrameImage::Ridges);
    int inside = 0;
    for_each_hit([&](const Vec3d& p, const float* pixel) {
        // Where samples end, the spline bends: within 3 of them.
        if (p.cwiseAbs().maxCoeff() > 1 - 6.0 / 31) return;
        ++inside;
        EXPECT_EQ(pixel[3], 0);
    });
    EXPECT_GT(inside, 500);
}

TEST_F(RidgeLines, HaveAThresholdOfTheFirstPictureThatIsKept) {
    Scene scene{.field = sampled(builtin_field("cube"), 48)};
    scene.look.effects.ridges.strength = 1;
    renderer.load(scene);
    const auto notes_of = [&](const Camera& view) {
        return renderer.draw(view, size, size, {FrameImage::Beauty}).notes;
    };
    // Where nothing is seen, nothing is learnt.
    EXPECT_TRUE(notes_of({.eye_world = {0, 0, 50}, .target_world = {0, 0, 100}}).empty());
    const std::vector<std::string> of_a_dent =
        notes_of({.eye_world = {0, 0, 6}, .fov_y_degrees = 3});
    ASSERT_EQ(of_a_dent.size(), 1U);
    EXPECT_EQ(notes_of(camera), of_a_dent);
    renderer.set_look(renderer.look());
    EXPECT_EQ(notes_of(camera), of_a_dent);
    renderer.load(scene);
    EXPECT_NE(notes_of(camera), of_a_dent);
}

TEST_F(RidgeLines, HaveHalfTheCurvatureOfATubeAsThreshold) {
    Scene scene{.field = sampled(builtin_field("torus"), 48)};
    draw(scene, FrameImage::Ridges);
    EXPECT_EQ(report.notes, std::vector<std::string>{"ridges: threshold 1.25 per unit"});
}

TEST_F(RidgeLines, AreNothingAtStrengthZero) {
    Look look;
    look.effects.ridges = {.strength = 0, .threshold = 1};
    expect_nothing_at_strength_zero(*this, look);
}

TEST_F(RidgeLines, AloneNeedNoShadingAndNoGradients) {
    expect_no_more_passes(*this, FrameImage::Ridges, {"raycast", "curvature", "ridges"});
}

TEST_F(RidgeLines, WithContoursTakeTheHessianOnce) {
    Scene scene{.field = sampled(builtin_field("gyroid"), 32)};
    const Image ridges = draw(scene, FrameImage::Ridges);
    const Image contours = draw(scene, FrameImage::Contours);
    renderer.load(scene);
    report = renderer.draw(camera, size, size, {FrameImage::Ridges, FrameImage::Contours});
    EXPECT_EQ(pass("view curvature").drawn_by, "curvature");
    EXPECT_EQ(renderer.read(FrameImage::Ridges).rgba, ridges.rgba);
    EXPECT_EQ(renderer.read(FrameImage::Contours).rgba, contours.rgba);
}

TEST_F(RidgeLines, AreFiniteAnywhere) {
    expect_finite_anywhere(*this, FrameImage::Ridges);
}

} // namespace
} // namespace isocast::test
