// Ambient occlusion where the share of the sky is known.
// SPDX-License-Identifier: MPL-2.0
#include "disc.h"
#include "scenes.h"
#include "volume/errors.h"

#include <numbers>

namespace isocast::test {
namespace {

struct Occlusions : Shading {
    Image hits;
    Image seen;

    void look_at(std::shared_ptr<const FieldSource> field, double distance_world, int rays) {
        Scene scene{.field = std::move(field)};
        scene.look.effects.occlusion = {.distance_world = distance_world, .rays = rays};
        look_at(scene);
    }
    void look_at(const Scene& scene) {
        renderer.load(scene);
        report = renderer.draw(camera, size, size, {FrameImage::Occlusion, FrameImage::Hit});
        hits = renderer.read(FrameImage::Hit);
        seen = renderer.read(FrameImage::Occlusion);
    }
    double share(const HitPixel& at) const { return seen.pixel(at.x, at.y)[0]; }
};

AnalyticField plane_through(const Vec3d& p0, const Vec3d& normal) {
    return {"plane",
            [=](const Vec3d& p) { return Jet{.value = (p - p0).dot(normal.normalized())}; }};
}

TEST_F(Occlusions, LeaveAPlaneTheWholeSky) {
    size = 48;
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        look_at(sampled(plane_through({0, 0, 0.1}, {0.3, 0.4, 1}), 48), 5, 64);
        int count = 0;
        for (const HitPixel& at : hit_pixels(hits, camera)) {
            if (is_near_border(at.p)) continue;
            ++count;
            EXPECT_EQ(share(at), 1) << at.p.transpose();
        }
        EXPECT_GT(count, 300);
    }
}

/// A wall at x = 0 over the floor: it hides the directions that reach it within the distance, a
/// segment of the disc under the sky. At the edge that is half of it.
TEST_F(Occlusions, OfAFloorBesideAWallAreTheSegmentOfTheDisc) {
    const AnalyticField corner{"corner", [](const Vec3d& p) {
                                   return Jet{.value = std::min(p.x() + 0.5, p.z() - floor_z)};
                               }};
    camera = {.eye_world = {2, -2, 2},
              .target_world = {-0.1, 0, floor_z},
              .up = Vec3d::UnitZ(),
              .fov_y_degrees = 20};
    constexpr double distance = 0.6;
    constexpr int rays = 64;
    size = 64;
    look_at(sampled(corner, 64), distance, rays);
    int count = 0;
    double sum = 0;
    double nearest = 1;
    for (const HitPixel& at : floor_pixels(hits, camera)) {
        // The field ends at 1: what reaches beyond would see nothing.
        if (std::abs(at.p.y()) > 1 - distance) continue;
        const double s = (at.p.x() + 0.5) / distance;
        // Two voxels: there the spline rounds the edge.
        if (s * distance < 0.065) continue;
        const double hidden =
            s < 1 ? (std::acos(s) - s * std::sqrt(1 - s * s)) / std::numbers::pi : 0;
        ++count;
        sum += share(at) - (1 - hidden);
        // A straight line cuts some 2 sqrt(64) cells of an even share each, half of them in excess
        // at worst two in a row: three rays.
        EXPECT_NEAR(share(at), 1 - hidden, 3.0 / rays) << s;
        nearest = std::min(nearest, share(at));
    }
    EXPECT_GT(count, 300);
    EXPECT_NEAR(sum / count, 0, 0.05 / rays);
    EXPECT_LT(nearest, 0.6);
}

/// The form factor of a sphere above the horizon: (r / d)^2 cos.
TEST_F(Occlusions, OfAFloorUnderABallAreItsFormFactor) {
    const Ball ball{.centre = {0, 0, floor_z + 0.5}, .radius = 0.3};
    camera = {.eye_world = {1.5, -3, 2.5},
              .target_world = {0, 0, -0.6},
              .up = Vec3d::UnitZ(),
              .fov_y_degrees = 20};
    size = 64;
    const auto worst_and_mean = [&](int rays) {
        look_at(floor_and_ball(ball), 4, rays);
        double worst = 0;
        double sum = 0;
        int count = 0;
        for (const HitPixel& at : floor_pixels(hits, camera)) {
            const Vec3d to_ball = ball.centre - at.p;
            const double d = to_ball.norm();
            const double hidden = ball.radius * ball.radius / (d * d) * to_ball.z() / d;
            worst = std::max(worst, std::abs(share(at) - (1 - hidden)));
            sum += share(at) - (1 - hidden);
            ++count;
        }
        EXPECT_GT(count, 1000);
        return std::pair(worst, sum / count);
    };
    const auto [worst_of_few, mean_of_few] = worst_and_mean(16);
    const auto [worst_of_many, mean_of_many] = worst_and_mean(256);
    // A closed curve on the disc cuts O(sqrt n) of n even cells, whose errors partly cancel.
    EXPECT_LT(worst_of_few, 3.0 / 16);
    EXPECT_LT(worst_of_many, 6.0 / 256);
    // Turned from pixel to pixel, errors of rays at random would cancel to one in sqrt(1000 pixels)
    // of a ray's, 0.03, and the same for three times as many cells.
    EXPECT_NEAR(mean_of_few, 0, 0.05 / 16);
    EXPECT_NEAR(mean_of_many, 0, 0.1 / 256);
}

TEST_F(Occlusions, KnowNoOccludersBeyondTheDistance) {
    const Ball ball{.centre = {0, 0, floor_z + 0.6}, .radius = 0.3};
    camera = {.eye_world = {1.5, -3, 2.5}, .target_world = {0, 0, -0.6}, .up = Vec3d::UnitZ()};
    size = 64;
    look_at(floor_and_ball(ball), 0.29, 64);
    for (const HitPixel& at : floor_pixels(hits, camera)) EXPECT_EQ(share(at), 1);
    look_at(floor_and_ball(ball), 0.4, 64);
    double least = 1;
    for (const HitPixel& at : floor_pixels(hits, camera)) {
        const bool is_near = (at.p - ball.centre).norm() < 0.7;
        if (!is_near) {
            EXPECT_EQ(share(at), 1);
        }
        least = std::min(least, share(at));
    }
    EXPECT_LT(least, 1);
}

/// From inside a sphere a ray meets it after 2 R cos: within D for cos < D / 2R, a share of its
/// square.
TEST_F(Occlusions, InsideASphereGoWithTheSquareOfTheDistance) {
    camera = {.eye_world = {0.2, 0.1, 0.3}, .target_world = {1, 0.2, -0.4}, .fov_y_degrees = 80};
    size = 48;
    constexpr int rays = 100;
    for (const double distance : {0.5, 1.0, 1.5}) {
        look_at(sampled(builtin_field("sphere"), 48), distance, rays);
        const double expected = 1 - distance * distance / 4;
        // The directions' heights are at (i + 1/2) / n: one ray to either side.
        for (const HitPixel& at : hit_pixels(hits, camera))
            EXPECT_NEAR(share(at), expected, 1.0 / rays + 1e-6) << at.p.transpose();
    }
}

/// Ray by ray against the same directions in double, on a grid that is turned and stretched.
TEST_F(Occlusions, CountTheRaysThatMeetTheBall) {
    const Ball ball{.centre = {0.1, 0, floor_z + 0.5}, .radius = 0.3};
    constexpr int rays = 24;
    size = 48;
    camera.up = Vec3d::UnitZ();
    camera.eye_world = {2, -2, 1};
    camera.target_world = {0, 0, floor_z};
    camera.fov_y_degrees = 20;
    look_at(on_grid(floor_and(ball), skew_space(), {80, 64, 96}), 4, rays);
    int different = 0;
    int count = 0;
    for (const HitPixel& at : floor_pixels(hits, camera)) {
        // Tangents u, v of the normal z, as Duff's formula gives them: x, y.
        const double turns = turns_of_pixel(at.x + 0.5, size - at.y - 0.5);
        int blocked = 0;
        for (int i = 0; i < rays; ++i) {
            const Eigen::Vector2d q = disc_point(i, rays, turns);
            const Vec3d d(q.x(), q.y(), std::sqrt(1 - q.squaredNorm()));
            blocked += (ball.centre - at.p).dot(d) > 0 &&
                       (ball.centre - at.p).cross(d).norm() < ball.radius;
        }
        ++count;
        different += std::lround((1 - share(at)) * rays) != blocked;
    }
    EXPECT_GT(count, 500);
    // Rays that graze the ball within 1e-3, the ball's error on voxels of 0.04: of those that
    // could, 2 pi r 2e-3 of 2 pi, for each of 24 rays; or the floor's normal errs near the ball.
    EXPECT_LT(different, 0.01 * count);
}

FieldObject object(AnalyticField field, int n = 48) {
    return {.field = sampled(field, n)};
}
AnalyticField sphere_at(const Ball& ball) {
    return {"ball",
            [=](const Vec3d& p) { return Jet{.value = (p - ball.centre).norm() - ball.radius}; }};
}

/// Ray by ray as above; here both surfaces and their normals are exact.
TEST_F(Occlusions, OfAUnionOfTwoBallsCountTheRaysThatMeetTheOther) {
    const std::array balls{Ball{.centre = {-0.35, 0, 0.1}, .radius = 0.45},
                           Ball{.centre = {0.4, 0.1, -0.1}, .radius = 0.35}};
    constexpr int rays = 24;
    size = 64;
    Scene scene{.objects = {{.field = on_grid(sphere_at(balls[0]), skew_space(), {80, 64, 96})},
                            object(sphere_at(balls[1]))}};
    scene.look.effects.occlusion = {.distance_world = 4, .rays = rays};
    look_at(scene);
    std::array<int, 2> counts{};
    int different = 0;
    int darkened = 0;
    for (const HitPixel& at : hit_pixels(hits, camera)) {
        const int own = std::lround(hits.pixel(at.x, at.y)[3]) - 1;
        const Ball& other = balls[static_cast<std::size_t>(1 - own)];
        const Vec3d n = (at.p - balls[static_cast<std::size_t>(own)].centre).normalized();
        int blocked = 0;
        for (int i = 0; i < rays; ++i) {
            const Vec3d d =
                sky_direction(i, rays, turns_of_pixel(at.x + 0.5, size - at.y - 0.5), n);
            blocked += (other.centre - at.p).dot(d) > 0 &&
                       (other.centre - at.p).cross(d).norm() < other.radius;
        }
        ++counts[static_cast<std::size_t>(own)];
        darkened += blocked > 0;
        different += std::lround((1 - share(at)) * rays) != blocked;
    }
    EXPECT_GT(counts[0], 200);
    EXPECT_GT(counts[1], 100);
    EXPECT_GT(darkened, 150);
    // As above.
    EXPECT_LT(different, 0.01 * (counts[0] + counts[1]));
}

TEST_F(Occlusions, OfAnObjectWithItselfAreItsOwn) {
    size = 64;
    const FieldObject gyroid{.field = sampled(builtin_field("gyroid"), 32)};
    Scene plain{.field = gyroid.field};
    plain.look.effects.occlusion.rays = 8;
    look_at(plain);
    const Image alone = seen;
    for (const CsgOperation operation : {CsgOperation::Union, CsgOperation::Intersection}) {
        Scene twice{.look = plain.look,
                    .objects = {gyroid, gyroid},
                    .tree = {{CsgOperation::Object, 0}, {CsgOperation::Object, 1}, {operation}}};
        look_at(twice);
        int count = 0;
        int different = 0;
        int dark = 0;
        for (const HitPixel& at : hit_pixels(hits, camera)) {
            ++count;
            dark += share(at) < 1;
            different += std::abs(share(at) - alone.pixel(at.x, at.y)[0]) > 1e-6;
        }
        EXPECT_GT(count, 500);
        EXPECT_GT(dark, 200);
        // Rays that graze, or that end at a root within rounding.
        EXPECT_LT(different, 0.01 * count);
    }
}

/// Of a ball's inside every point sees any other part of it as the part's share of the area: from a
/// bowl that is half a ball, half of the sky is seen, wherever one stands.
TEST_F(Occlusions, OfABowlCutIntoAFloorAreHalfOfTheSky) {
    const Ball bowl{.centre = {0.1, 0, 0}, .radius = 0.6};
    camera = {.eye_world = {0.3, -1, 3}, .target_world = {0, 0, 0}, .up = Vec3d::UnitZ()};
    size = 64;
    constexpr int rays = 64;
    Scene scene{
        .objects = {object(plane_through(Vec3d::Zero(), Vec3d::UnitZ())),
                    object(sphere_at(bowl), 64)},
        .tree = {{CsgOperation::Object, 0}, {CsgOperation::Object, 1}, {CsgOperation::Difference}}};
    scene.look.effects.occlusion = {.distance_world = 3, .rays = rays};
    look_at(scene);
    int in_bowl = 0;
    int on_floor = 0;
    double sum = 0;
    for (const HitPixel& at : hit_pixels(hits, camera)) {
        const bool is_cut = hits.pixel(at.x, at.y)[3] < 0;
        // Two voxels from the rim, and from the field's border.
        if (is_near_border(at.p) || (is_cut && at.p.z() > -0.06)) continue;
        if (is_cut) {
            ++in_bowl;
            sum += share(at) - 0.5;
            EXPECT_NEAR(share(at), 0.5, 5.0 / rays) << at.p.transpose();
        } else {
            ++on_floor;
            EXPECT_EQ(share(at), 1) << at.p.transpose();
        }
    }
    EXPECT_GT(in_bowl, 200);
    EXPECT_GT(on_floor, 200);
    // As under a ball.
    EXPECT_NEAR(sum / in_bowl, 0, 0.1 / rays);
    EXPECT_EQ(report.notes.size(), 1u) << "the picture's composition, not that of each ray";
}

TEST_F(Occlusions, AndAnOverviewAreNoStepsOfThePicturesRays) {
    size = 300; // larger than an overview
    Scene scene{.objects = {object(sphere_at({.centre = {0.3, 0, 0}, .radius = 0.5}), 24),
                            object(sphere_at({.centre = {-0.3, 0, 0}, .radius = 0.5}), 24)}};
    const Image alone = draw(scene, FrameImage::Steps);
    scene.look.effects.occlusion.rays = 2;
    renderer.load(scene);
    report = renderer.draw(camera, size, size,
                           {FrameImage::Steps, FrameImage::Occlusion, FrameImage::CurvatureColour});
    EXPECT_TRUE(pass("occlusion").ran && pass("curvature colour").ran);
    EXPECT_EQ(renderer.read(FrameImage::Steps).rgba, alone.rgba);
    EXPECT_GT(std::ranges::max(alone.rgba), 1);
}

TEST_F(Occlusions, AreNumbersWhereTheGradientVanishes) {
    const AnalyticField flat{"flat",
                             [](const Vec3d& p) { return Jet{.value = p.z() * p.z() * p.z()}; }};
    size = 32;
    look_at(sampled(flat, 17), 1, 8);
    for (const HitPixel& at : hit_pixels(hits, camera)) {
        ASSERT_GE(share(at), 0);
        ASSERT_LE(share(at), 1);
    }
}

TEST_F(Occlusions, DarkenAmbientLightAlone) {
    size = 48;
    Scene scene{.field = sampled(builtin_field("gyroid"), 32)};
    scene.look.effects.occlusion.rays = 8;
    scene.look.material = {.ambient = 0.7, .diffuse = 0, .specular = 0};
    const Image bright = draw(scene);
    scene.look.effects.occlusion.strength = 0.5;
    const Image dim = draw(scene);
    renderer.draw(camera, size, size, {FrameImage::Occlusion, FrameImage::Hit});
    seen = renderer.read(FrameImage::Occlusion);
    for (const HitPixel& at : hit_pixels(renderer.read(FrameImage::Hit), camera))
        for (int c = 0; c < 3; ++c) // 2^-10: roundings of the beauty's halves
            EXPECT_NEAR(dim.pixel(at.x, at.y)[c],
                        bright.pixel(at.x, at.y)[c] * (0.5 + 0.5 * share(at)), 0x1p-10);
}

TEST_F(Occlusions, OfStrengthZeroDoNotExist) {
    Scene scene{.field = sampled(builtin_field("gyroid"), 32)};
    const Image plain = draw(scene);
    const FrameReport of_plain = report;
    scene.look.effects.occlusion = {.strength = 0, .rays = 99};
    EXPECT_EQ(draw(scene).rgba, plain.rgba);
    EXPECT_FALSE(pass("occlusion").ran);
    EXPECT_EQ(report.image_bytes, of_plain.image_bytes);
    EXPECT_EQ(report.programs_compiled, of_plain.programs_compiled);
}

TEST_F(Occlusions, AloneRunNoShading) {
    size = 32;
    look_at({.field = sampled(builtin_field("gyroid"), 32)});
    std::string ran;
    for (const PassReport& p : report.passes)
        if (p.ran) ran += p.name + ", ";
    EXPECT_EQ(ran, "raycast, gradient, occlusion, ");
    ASSERT_EQ(report.notes.size(), 1U) << "how far occluders count";
}

TEST_F(Occlusions, NeedAllBricksAndSensibleNumbers) {
    Scene scene{.field = sampled(builtin_field("gyroid"), 48)};
    renderer.load(scene);
    scene.storage.budget_bytes = renderer.pool().byte_count() / 3;
    renderer.load(scene);
    EXPECT_THROW(renderer.draw(camera, size, size, {FrameImage::Occlusion}), ResourceError);
    scene.look.effects.occlusion.rays = 0;
    EXPECT_THROW(renderer.load(scene), InputError);
    scene.look.effects.occlusion = {.distance_world = 0};
    EXPECT_THROW(renderer.load(scene), InputError);
}

} // namespace
} // namespace isocast::test
