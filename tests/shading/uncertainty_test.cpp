// Uncertainty on fields whose flow lines and gradients are known.
// SPDX-License-Identifier: MPL-2.0
#include "effect_rules.h"

#include "filtering/curvature.h"

namespace isocast::test {
namespace {

struct Uncertainties : Shading {
    /// Calls visit(p_world, coverage) at every hit; returns how many there are.
    template<class Visit>
    int for_each_hit(Visit visit) const {
        const Image hits = renderer.read(FrameImage::Hit);
        const Image image = renderer.read(FrameImage::Uncertainty);
        int count = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            const float* hit = &hits.rgba[i];
            if (hit[3] == 0) {
                EXPECT_EQ(image.rgba[i + 3], 0);
                continue;
            }
            ++count;
            visit(Vec3d(camera.eye_world + Vec3d(hit[0], hit[1], hit[2])), image.rgba[i + 3]);
        }
        return count;
    }
};

TEST_F(Uncertainties, AreNoneInAFieldOfDistances) {
    for (const std::string_view name : {"sphere", "torus"}) {
        draw({.field = sampled(builtin_field(name), 48)}, FrameImage::Uncertainty);
        const int count = for_each_hit([&](const Vec3d&, float coverage) {
            // Flow lines are straight. The spline's turn by (1/12) of a fourth derivative, 15/r^3
            // of a tube of r = 5.4 voxels at most: 0.008 per voxel, where 1/32 is the least range.
            EXPECT_LT(coverage, 0.25) << name;
        });
        EXPECT_GT(count, 500);
    }
}

TEST_F(Uncertainties, AreHowFlowLinesOfTheCubeBend) {
    const AnalyticField cube = builtin_field("cube");
    Scene scene{.field = sampled(cube, 64)};
    scene.look.effects.uncertainty = {.range = 2.0, .typical_gradient = 3.0};
    draw(scene, FrameImage::Uncertainty);
    double greatest = 0;
    for_each_hit([&](const Vec3d& p, float coverage) {
        const Jet jet = cube.jet(p);
        // Along a flow line: how far the normal turns over a short way, by gradients alone.
        const Vec3d n = jet.gradient.normalized();
        constexpr double step = 1e-5;
        const Vec3d after = cube.jet(p + step * n).gradient.normalized();
        const Vec3d before = cube.jet(p - step * n).gradient.normalized();
        const double turning = (after - before).norm() / (2 * step);
        const double moving = 1 - 2 * jet.gradient.norm() / 3;
        // 0.005: second derivatives of a quartic at 1/21 voxels err by 24/12/21^2 of 3.
        EXPECT_NEAR(coverage, std::clamp(std::max(turning / 2, moving), 0.0, 1.0), 0.01);
        greatest = std::max(greatest, turning / 2);
    });
    EXPECT_GT(greatest, 0.4);
}

TEST_F(Uncertainties, RiseWhereTheGradientIsWeak) {
    // A sphere's distance times what falls from 1.9 to 0.1 along x.
    const auto strength = [](const Vec3d& p) { return 1 - 0.9 * p.x(); };
    const AnalyticField weak{
        "weak", [&](const Vec3d& p) { return Jet{.value = (p.norm() - 1) * strength(p)}; }, 1.1};
    Scene scene{.field = sampled(weak, 48)};
    scene.look.effects.uncertainty.range = 1e6;
    scene.look.effects.uncertainty.typical_gradient = 1.0;
    draw(scene, FrameImage::Uncertainty);
    const int count = for_each_hit([&](const Vec3d& p, float coverage) {
        EXPECT_NEAR(coverage, std::clamp(1 - 2 * strength(p), 0.0, 1.0), 0.01);
    });
    EXPECT_GT(count, 500);
}

TEST_F(Uncertainties, NoteWhatTheyChoseAndKeepIt) {
    Scene scene{.field = sampled(builtin_field("cube"), 48)};
    const Image first = draw(scene, FrameImage::Uncertainty);
    ASSERT_EQ(report.notes.size(), 1U);
    camera.eye_world = {4, 1, 1};
    const FrameReport other = renderer.draw(camera, size, size, {FrameImage::Uncertainty});
    EXPECT_EQ(other.notes, report.notes);
}

TEST_F(Uncertainties, AreNothingAtStrengthZero) {
    Look look;
    look.effects.uncertainty = {.strength = 0, .range = 1};
    expect_nothing_at_strength_zero(*this, look);
}

TEST_F(Uncertainties, AloneNeedNoShadingAndNoPrincipalCurvatures) {
    expect_no_more_passes(*this, FrameImage::Uncertainty,
                          {"raycast", "gradient", "flow line curvature", "uncertainty"});
}

TEST_F(Uncertainties, AreFiniteAnywhere) {
    expect_finite_anywhere(*this, FrameImage::Uncertainty);
}

} // namespace
} // namespace isocast::test
