// How cameras move, and how much is drawn while they do.
// SPDX-License-Identifier: MPL-2.0
#include "apps/view/navigation.h"
#include "apps/view/pace.h"

#include <gtest/gtest.h>

#include <random>

namespace isocast::view::test {
namespace {

struct Navigation : testing::Test {
    std::mt19937 random{3};
    double any(double lo, double hi) {
        return std::uniform_real_distribution<double>(lo, hi)(random);
    }
    Vec3d any_point(double reach) {
        return {any(-reach, reach), any(-reach, reach), any(-reach, reach)};
    }
    Camera any_camera() {
        Camera camera{.eye_world = any_point(1) + Vec3d(0, 0, 5), .target_world = any_point(0.5)};
        camera.up = Vec3d(any(-0.3, 0.3), 1, 0);
        camera.fov_y_degrees = any(10, 80);
        camera.height_world = any(1, 5);
        if (random() % 2) camera.projection = Projection::Orthographic;
        return camera;
    }
    /// Pixels from the top left corner, of 640x480.
    static Eigen::Vector2d seen(const Camera& camera, const Vec3d& p_world) {
        const Vec3d p = camera.view_from_world_rotation() * (p_world - camera.eye_world);
        const double pixels =
            480 /
            (2 * camera.half_height_at(camera.projection == Projection::Perspective ? -p.z() : 1));
        return {320 + pixels * p.x(), 240 - pixels * p.y()};
    }
    static double distance(const Camera& camera, const Vec3d& p) {
        return (p - camera.eye_world).norm();
    }
};

// 1e-9: some tens of roundings of numbers of up to a thousand pixels, at 1e-13 each, seen through
// divisions by depths of a unit.
constexpr double rounding = 1e-9;

TEST_F(Navigation, RotationKeepsThePivotWhereItIsSeen) {
    for (int i = 0; i < 200; ++i) {
        const Camera before = any_camera();
        const Vec3d pivot = any_point(1);
        const Camera after = rotated(before, pivot, any(-3, 3), any(-3, 3));
        EXPECT_LT((seen(after, pivot) - seen(before, pivot)).norm(), rounding);
        EXPECT_NEAR(distance(after, pivot), distance(before, pivot), rounding);
    }
}

TEST_F(Navigation, RotationFollowsTheMouse) {
    const Camera camera{.eye_world = {0, 0, 5}};
    const Vec3d front(0, 0, 1);
    // As Window does for a mouse that goes right and down.
    const Eigen::Vector2d moved =
        seen(rotated(camera, Vec3d::Zero(), 0.1, 0.1), front) - seen(camera, front);
    EXPECT_LT(moved.x(), 0); // the camera goes right about up: the front goes left
    EXPECT_GT(seen(rotated(camera, Vec3d::Zero(), -0.1, 0), front).x(), 320);
    EXPECT_GT(seen(rotated(camera, Vec3d::Zero(), 0, -0.1), front).y(), 240);
}

TEST_F(Navigation, PanningMovesThePivotWithTheMouse) {
    for (int i = 0; i < 200; ++i) {
        const Camera before = any_camera();
        const Vec3d pivot = any_point(1);
        const Eigen::Vector2d by(any(-100, 100), any(-100, 100));
        const Camera after = panned(before, pivot, 480, by.x(), by.y());
        EXPECT_LT((seen(after, pivot) - seen(before, pivot) - by).norm(), rounding);
    }
}

TEST_F(Navigation, ZoomingKeepsWhatIsUnderTheCursor) {
    for (int i = 0; i < 200; ++i) {
        const Camera before = any_camera();
        const Vec3d pivot = any_point(1);
        const Eigen::Vector2d at = seen(before, pivot);
        const double factor = any(0.5, 2);
        const Camera after = zoomed(before, pivot, 640, 480, at.x(), at.y(), factor);
        EXPECT_LT((seen(after, pivot) - at).norm(), rounding);
        if (before.projection == Projection::Orthographic)
            EXPECT_NEAR(after.height_world, factor * before.height_world, rounding);
        else
            EXPECT_NEAR(distance(after, pivot), factor * distance(before, pivot), rounding);
        EXPECT_GT((after.target_world - after.eye_world).norm(), 0);
    }
}

TEST_F(Navigation, RollingTurnsThePictureAboutItsMiddle) {
    for (int i = 0; i < 200; ++i) {
        const Camera before = any_camera();
        const Vec3d p = any_point(1);
        const double angle = any(-3, 3);
        const Eigen::Vector2d middle(320, 240);
        const Eigen::Vector2d from = seen(before, p) - middle;
        // Counter-clockwise, where y goes down.
        const Eigen::Vector2d expected(std::cos(angle) * from.x() + std::sin(angle) * from.y(),
                                       -std::sin(angle) * from.x() + std::cos(angle) * from.y());
        EXPECT_LT((seen(rolled(before, angle), p) - middle - expected).norm(), rounding);
    }
}

TEST_F(Navigation, TheOtherProjectionKeepsSizesAtThePivot) {
    for (int i = 0; i < 200; ++i) {
        const Camera before = any_camera();
        // On the plane through what the camera looks at.
        const Vec3d pivot = before.target_world;
        const Vec3d right = before.view_from_world_rotation().row(0).transpose();
        const Camera after = with_other_projection(before, pivot);
        EXPECT_NE(after.projection, before.projection);
        for (const double step : {0.0, 0.3})
            EXPECT_LT(
                (seen(after, pivot + step * right) - seen(before, pivot + step * right)).norm(),
                rounding);
    }
}

FrameReport report_of(std::initializer_list<std::pair<const char*, double>> passes) {
    FrameReport report;
    for (const auto& [name, milliseconds] : passes)
        report.passes.push_back({.name = name, .ran = true, .milliseconds = milliseconds});
    return report;
}

TEST(Pace, ReducesAsFarAsMeasuredTimesAsk) {
    Pace pace;
    Look look;
    const double pixels = 1e6;
    EXPECT_EQ(pace.reduction_for(look, pixels, 33), (Reduction{1, true})); // nothing was seen
    pace.saw(report_of({{"raycast", 200}, {"shading", 40}}), pixels, 250);
    // 10 ms that do not depend on pixels, 240 that do: a ninth of them and 10 are 37, a
    // sixteenth 25.
    EXPECT_EQ(pace.reduction_for(look, pixels, 250), (Reduction{1, true}));
    EXPECT_EQ(pace.reduction_for(look, pixels, 70), (Reduction{2, true}));
    EXPECT_EQ(pace.reduction_for(look, pixels, 37), (Reduction{3, false}));
    EXPECT_EQ(pace.reduction_for(look, pixels, 33), (Reduction{4, false}));
    EXPECT_EQ(pace.reduction_for(look, pixels, 1), (Reduction{greatest_divisor, false}));
}

TEST(Pace, DearEffectsGoBeforeResolutionDoes) {
    Pace pace;
    Look look;
    look.effects.occlusion.strength = 1;
    pace.saw(report_of({{"raycast", 30}, {"occlusion", 1000}}), 1e6, 1030);
    EXPECT_EQ(pace.reduction_for(look, 1e6, 33), (Reduction{1, false}));
    EXPECT_EQ(pace.reduction_for(look, 1e6, 300), (Reduction{2, true}));
    look.effects.occlusion.strength = 0; // what is off costs nothing
    EXPECT_EQ(pace.reduction_for(look, 1e6, 33), (Reduction{1, true}));
    pace.saw(report_of({{"curvature", 500}, {"curvature colour", 500}}), 1e6, 1000);
    EXPECT_EQ(pace.reduction_for(look, 1e6, 33), (Reduction{1, true}));
    look.effects.ridges.strength = 1; // needs curvatures, too
    EXPECT_NE(pace.reduction_for(look, 1e6, 33), (Reduction{1, true}));
    EXPECT_EQ(without_expensive_effects(look).effects.occlusion.strength, 0);
}

} // namespace
} // namespace isocast::view::test
