// Shadows of surfaces whose shadows are known.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/reconstruct.h"
#include "raycaster/effects/shadow.h"
#include "raycaster/reference.h"
#include "scenes.h"
#include "volume/errors.h"

#include <Eigen/Eigenvalues>

#include <numbers>

namespace isocast::test {
namespace {

struct Shadows : Shading {
    Image hits;
    Image shadow;

    /// One light, 512 texels.
    static Light light_from(const Vec3d& direction, Shadow kind, double size_degrees = 3) {
        return {.direction = direction,
                .is_in_view_space = false,
                .shadow = kind,
                .size_degrees = size_degrees,
                .shadow_map_pixels = 512};
    }
    void cast(Scene scene, const Light& light) {
        scene.look.lights = {light};
        renderer.load(scene);
        cast();
    }
    void cast() {
        report = renderer.draw(camera, size, size, {FrameImage::Shadow, FrameImage::Hit});
        hits = renderer.read(FrameImage::Hit);
        shadow = renderer.read(FrameImage::Shadow);
    }
    double texel_world() const {
        return light_view(renderer.look().lights[0], camera, 512, renderer.surface_box_world(), 0)
            .texel_world;
    }
    float share(const HitPixel& at) const { return shadow.pixel(at.x, at.y)[0]; }
    int samples(const HitPixel& at) const { return int(shadow.pixel(at.x, at.y)[1]); }
};

/// Beside its shadow, as seen from above.
const Ball ball{.centre = {0.4, 0.1, 0}, .radius = 0.25};
const Vec3d slanting(1, 0.2, 1.1);
const Camera from_above{.eye_world = {0, 0, 3},
                        .target_world = Vec3d::Zero(),
                        .up = Vec3d::UnitY(),
                        .projection = Projection::Orthographic,
                        .height_world = 1.9};

/// How far a point is from the axis of a ball's shadow.
double off_axis(const Vec3d& p, const Ball& b, const Vec3d& to_light) {
    return (p - b.centre).cross(to_light.normalized()).norm();
}

TEST_F(Shadows, OfASphereOnAPlaneIsTheAnalyticEllipse) {
    camera = from_above;
    size = 192;
    cast({.field = floor_and_ball(ball)}, light_from(slanting, Shadow::Hard));
    // Four texels around a point decide; the farthest is a texel's diagonal away.
    const double tolerance = std::numbers::sqrt2 * texel_world();
    double sum = 0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
    for (const HitPixel& at : floor_pixels(hits, camera)) {
        const double distance = off_axis(at.p, ball, slanting);
        if (distance > ball.radius + tolerance) {
            EXPECT_EQ(share(at), 1) << at.p.transpose();
        }
        if (distance < ball.radius - tolerance) {
            EXPECT_EQ(share(at), 0) << at.p.transpose();
        }
        EXPECT_EQ(samples(at), 4);
        const Eigen::Vector2d p = at.p.head<2>();
        sum += 1 - share(at);
        mean += (1 - share(at)) * p;
        square += (1 - share(at)) * p * p.transpose();
    }
    mean /= sum;
    const Eigen::Matrix2d spread = square / sum - mean * mean.transpose();
    // The cylinder's section: semi-axes r and r / cos of the light's angle. Pixels of 0.01 sample
    // its border of 1.9: some 190 errors of a tenth of a pixel, since texels' weights smooth it,
    // are sqrt(190) 0.1 0.01^2 = 1.4e-4 of the area, and 1.4e-4 / 0.27 of a length; two of these.
    const double cosine = slanting.normalized().z();
    const double pi = std::numbers::pi;
    const double pixel = camera.height_world / size;
    EXPECT_NEAR(sum * pixel * pixel, pi * ball.radius * ball.radius / cosine, 3e-4);
    const Vec3d centre = ball.centre - slanting * (ball.centre.z() - floor_z) / slanting.z();
    EXPECT_LT((mean - centre.head<2>()).norm(), 1e-3);
    // An ellipse's points have a variance of a quarter of its semi-axis squared.
    const Eigen::Vector2d semi_axes =
        2 * Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvalues().cwiseSqrt();
    EXPECT_NEAR(semi_axes[0], ball.radius, 1e-3);
    EXPECT_NEAR(semi_axes[1], ball.radius / cosine, 1e-3);
}

TEST_F(Shadows, OnAGridThatIsTurnedAndStretchedIsTheSame) {
    const Ball small{.centre = {0.2, 0.1, -0.1}, .radius = 0.25};
    cast({.field = on_grid(floor_and(small), skew_space(), {80, 64, 96})},
         light_from(slanting, Shadow::Hard));
    const double tolerance = std::numbers::sqrt2 * texel_world();
    int dark = 0;
    for (const HitPixel& at : floor_pixels(hits, camera)) {
        const double distance = off_axis(at.p, small, slanting);
        if (distance > small.radius + tolerance) {
            EXPECT_EQ(share(at), 1) << at.p.transpose();
        }
        if (distance < small.radius - tolerance) {
            EXPECT_EQ(share(at), 0) << at.p.transpose();
        }
        dark += share(at) == 0;
    }
    EXPECT_GT(dark, 50);
}

TEST_F(Shadows, OfABallThatTouchesTheFloorBeginsAtTheContact) {
    const Ball resting{.centre = {0, 0, floor_z + 0.3}, .radius = 0.3};
    camera = {.eye_world = {2, -0.4, 0},
              .target_world = {0, 0, floor_z},
              .up = Vec3d::UnitZ(),
              .fov_y_degrees = 25};
    size = 192;
    const Vec3d to_light(0, 1, 0.9);
    cast({.field = floor_and_ball(resting)}, light_from(to_light, Shadow::Hard));
    const double tolerance = std::numbers::sqrt2 * texel_world();
    int near_contact = 0;
    for (const HitPixel& at : floor_pixels(hits, camera)) {
        if (off_axis(at.p, resting, to_light) > resting.radius - tolerance) continue;
        EXPECT_EQ(share(at), 0) << at.p.transpose();
        near_contact += at.p.head<2>().norm() < 0.15;
    }
    EXPECT_GT(near_contact, 20);
}

/// Share of the light's disc that a ball leaves free, by `count` points of the disc.
double free_share(const Vec3d& p, const Ball& b, const Vec3d& to_light, double size_degrees,
                  int count) {
    const Vec3d axis = to_light.normalized();
    const Vec3d u = axis.unitOrthogonal();
    const Vec3d v = axis.cross(u);
    const double spread = std::tan(size_degrees * std::numbers::pi / 360);
    int lit = 0;
    for (int i = 0; i < count; ++i) {
        const double radius = spread * std::sqrt((i + 0.5) / count);
        const Vec3d d = axis + radius * (std::cos(2.4 * i) * u + std::sin(2.4 * i) * v);
        lit += off_axis(p, b, d) > b.radius;
    }
    return double(lit) / count;
}

/// A ball's height over the floor, its radius, the light's size, the share of the penumbra's pixels
/// that may be taken for others.
struct Penumbra {
    double height, radius, size_degrees;
};
struct Penumbras : Shadows, testing::WithParamInterface<Penumbra> {};

TEST_P(Penumbras, LieBetweenTheAnalyticConesAndAreAsDarkAsTheLightIsHidden) {
    const auto [height, radius, size_degrees] = GetParam();
    const Ball b{.centre = {0, 0, floor_z + height}, .radius = radius};
    const Vec3d to_light(0.3, 0.2, 1);
    camera = {.eye_world = {1.5, -3, 2.5},
              .target_world = {0, 0, -0.5},
              .up = Vec3d::UnitZ(),
              .fov_y_degrees = 25};
    size = 192;
    cast({.field = floor_and_ball(b)}, light_from(to_light, Shadow::Soft, size_degrees));
    const double alpha = size_degrees * std::numbers::pi / 360;
    int penumbra = 0;
    int misjudged = 0;
    double sum = 0;
    double square = 0;
    for (const HitPixel& at : floor_pixels(hits, camera)) {
        const Vec3d to_ball = b.centre - at.p;
        const double seen_radius = std::asin(std::min(1.0, b.radius / to_ball.norm()));
        const double angle =
            std::acos(std::clamp(to_ball.normalized().dot(to_light.normalized()), -1.0, 1.0));
        // A texel and a half, as an angle: the map tells edges apart by a texel, read at the
        // nearest.
        const double texel = 1.5 * texel_world() / to_ball.norm();
        if (angle > seen_radius + alpha + texel) {
            EXPECT_EQ(share(at), 1) << at.p.transpose();
            EXPECT_EQ(samples(at), 8) << at.p.transpose();
        } else if (angle < seen_radius - alpha - texel - 0.2 * alpha * radius / height) {
            // 0.2: the dome over the shadow's edge is higher than its rim, by the radius at most;
            // the lowest of the samples takes it down to a fifth of that (measured).
            EXPECT_EQ(share(at), 0) << at.p.transpose();
            EXPECT_EQ(samples(at), 8) << at.p.transpose();
        } else {
            const double truth = free_share(at.p, b, to_light, size_degrees, 500);
            if (truth == 0 || truth == 1) continue;
            ++penumbra;
            misjudged += samples(at) == 8 && truth > 0.1 && truth < 0.9;
            sum += share(at) - truth;
            square += (share(at) - truth) * (share(at) - truth);
        }
    }
    RecordProperty("rms", std::to_string(std::sqrt(square / penumbra)));
    RecordProperty("mean", std::to_string(sum / penumbra));
    RecordProperty("misjudged", misjudged);
    RecordProperty("penumbra", penumbra);
    EXPECT_GT(penumbra, 40);
    // Independent jitter of eight samples would misjudge 0.9^8 = 43 % of those at the ends of this
    // range; a ring of seven sees what hides more than 6.5 % of the disc behind a straight edge,
    // and some of its samples go into finding how high the occluder is.
    EXPECT_LT(misjudged, 0.03 * penumbra);
    // 56 points of a disc err by 0.02 behind a straight edge; texels of a tenth of the penumbra add
    // as much.
    EXPECT_LT(std::sqrt(square / penumbra), 0.05);
    EXPECT_LT(std::abs(sum / penumbra), 0.01);
}

INSTANTIATE_TEST_SUITE_P(Heights, Penumbras,
                         testing::Values(Penumbra{0.5, 0.25, 4}, Penumbra{1, 0.25, 4},
                                         Penumbra{1, 0.25, 8}));

TEST_F(Shadows, DoNotFallOnTheLitSideOfASphere) {
    for (const Shadow kind : {Shadow::Hard, Shadow::Soft}) {
        const Vec3d to_light(-1, 0.3, 0.1);
        cast({.field = sampled(builtin_field("sphere"), 48)}, light_from(to_light, kind));
        int lit = 0;
        for (const HitPixel& at : hit_pixels(hits, camera)) {
            const double cosine = at.p.normalized().dot(to_light.normalized());
            // The sphere falls away from its tangent plane, so that the limit is how exact normals
            // are: 1e-3 rad at 48 samples.
            if (cosine > 1e-3) {
                EXPECT_EQ(share(at), 1) << cosine;
            }
            if (cosine < -1e-3) {
                EXPECT_EQ(share(at), 0) << cosine;
                EXPECT_EQ(samples(at), 0) << cosine;
            }
            lit += cosine > 1e-3;
        }
        EXPECT_GT(lit, 1000);
    }
}

TEST_F(Shadows, DoNotFallOnAPlaneInGrazingLight) {
    const Vec3d normal = Vec3d(0.2, 0.3, 1).normalized();
    const AnalyticField plane{"plane", [=](const Vec3d& p) { return Jet{.value = p.dot(normal)}; }};
    const Vec3d along = normal.unitOrthogonal();
    for (const Shadow kind : {Shadow::Hard, Shadow::Soft})
        for (const double degrees : {0.5, 5.0, 45.0}) {
            const double angle = degrees * std::numbers::pi / 180;
            cast({.field = sampled(plane, 48)},
                 light_from(std::sin(angle) * normal + std::cos(angle) * along, kind));
            int count = 0;
            for (const HitPixel& at : hit_pixels(hits, camera)) {
                if (is_near_border(at.p)) continue;
                ++count;
                EXPECT_EQ(share(at), 1) << degrees;
            }
            EXPECT_GT(count, 1000);
        }
}

TEST_F(Shadows, DoNotFallIntoABowlThatTheLightSeesWhole) {
    constexpr double radius = 1.6;
    const AnalyticField bowl{
        "bowl", [](const Vec3d& p) { return Jet{.value = radius - (p - Vec3d(0, 0, 1)).norm()}; }};
    camera = {.eye_world = {0.5, 0.3, 4}, .target_world = {0, 0, 0}};
    for (const Shadow kind : {Shadow::Hard, Shadow::Soft}) {
        cast({.field = sampled(bowl, 48)}, light_from(Vec3d::UnitZ(), kind));
        // Over a texel's diagonal the bowl rises from its tangent plane by 2 / (2 rho cos^3), and a
        // footprint of 1 / cos is allowed for.
        const double least_cosine = std::sqrt(texel_world() / radius);
        int count = 0;
        for (const HitPixel& at : hit_pixels(hits, camera)) {
            if ((1 - at.p.z()) / radius < least_cosine) continue;
            ++count;
            EXPECT_EQ(share(at), 1) << at.p.transpose();
        }
        EXPECT_GT(count, 1000);
    }
}

/// The gyroid from outside, in parallel, and from inside one of its labyrinths: light falls through
/// holes and onto both sides.
TEST_F(Shadows, AgreeWithRaysToTheLightOnTheGyroid) {
    const std::shared_ptr<const FieldSource> field = sampled(builtin_field("gyroid"), 48);
    const double voxel = field->space().voxel_size_world();
    const ReferenceCaster reference(*control_samples(field, Filter::Interpolating), 0);
    const Vec3d to_light = Vec3d(0.3, 1, 0.4).normalized();
    Camera parallel = camera;
    parallel.projection = Projection::Orthographic;
    const Camera inside{
        .eye_world = {0.25, 0.25, 0.25}, .target_world = {-0.4, -0.7, 0}, .fov_y_degrees = 70};
    size = 64;
    for (const Camera& view : {camera, parallel, inside}) {
        camera = view;
        cast({.field = field}, light_from(to_light, Shadow::Hard));
        renderer.draw(camera, size, size,
                      {FrameImage::Shadow, FrameImage::Hit, FrameImage::Gradient});
        const Image gradients = renderer.read(FrameImage::Gradient);
        const Vec3d forward = (camera.target_world - camera.eye_world).normalized();
        int judged = 0;
        int leaks = 0;
        int false_shadows = 0;
        for (const HitPixel& at : hit_pixels(hits, camera)) {
            if (samples(at) == 0) continue;
            const float* g = gradients.pixel(at.x, at.y);
            Vec3d normal = Vec3d(g[0], g[1], g[2]).normalized();
            const Vec3d view_direction =
                camera.projection == Projection::Perspective ? at.p - camera.eye_world : forward;
            if (normal.dot(view_direction) > 0) normal = -normal;
            ++judged;
            const bool is_lit = !reference.hit({at.p + 0.03 * voxel * normal, to_light});
            leaks += !is_lit && share(at) > 0.75;
            false_shadows += is_lit && share(at) < 0.25;
        }
        // A texel along each border of a shadow; more where light grazes a hollow, which the
        // footprint allows for.
        EXPECT_GT(judged, 500);
        EXPECT_LT(leaks, 0.025 * judged);
        EXPECT_LT(false_shadows, 0.002 * judged);
    }
}

TEST_F(Shadows, AreTheSameFarFromTheOrigin) {
    const auto at = [&](double offset) {
        const Vec3d o = Vec3d::Constant(offset);
        const AnalyticField near_origin = floor_and(ball);
        const AnalyticField moved{"moved", [=](const Vec3d& p) { return near_origin.jet(p - o); }};
        camera.eye_world = o + Vec3d(1.5, -3, 2.5);
        camera.target_world = o;
        cast({.field =
                  on_grid(moved, GridSpace::uniform(1.0 / 32, o - Vec3d::Ones()), {65, 65, 65})},
             light_from(slanting, Shadow::Soft));
        return shadow;
    };
    const Image near_origin = at(0);
    const Image far_away = at(1e6);
    int different = 0;
    int partial = 0;
    for (std::size_t i = 0; i < near_origin.rgba.size(); i += 4) {
        different += std::abs(near_origin.rgba[i] - far_away.rgba[i]) > 0.1;
        partial += near_origin.rgba[i] > 0 && near_origin.rgba[i] < 1;
    }
    // A double at 1e6 has 1e-10, so that roundings alone differ: a few of the penumbra's pixels.
    EXPECT_GT(partial, 50);
    EXPECT_LT(different, 5);
}

TEST_F(Shadows, AreTheSameByAllTraversalsAndWhenStreamed) {
    Scene scene{.field = floor_and_ball(ball)};
    Light soft = light_from(slanting, Shadow::Soft);
    soft.shadow_map_pixels = 96;
    size = 48;
    cast(scene, soft);
    const Image by_lists = shadow;
    for (const Traversal traversal :
         {Traversal::DrawnBlocks, Traversal::BoundingFaces, Traversal::Walk}) {
        scene.quality.traversal = traversal;
        cast(scene, soft);
        EXPECT_EQ(shadow.rgba, by_lists.rgba);
    }
    scene.quality.traversal = Traversal::TileLists;
    scene.storage.budget_bytes = renderer.pool().byte_count() / 3;
    cast(scene, soft);
    EXPECT_LT(renderer.pool().resident_count(), renderer.pool().brick_count());
    EXPECT_EQ(shadow.rgba, by_lists.rgba);
}

TEST_F(Shadows, AreNumbersWhereTheGradientVanishes) {
    // z^3: the floor, without a gradient.
    const AnalyticField flat{"flat",
                             [](const Vec3d& p) { return Jet{.value = p.z() * p.z() * p.z()}; }};
    size = 32;
    for (const Shadow kind : {Shadow::Hard, Shadow::Soft}) {
        Light light = light_from({0.3, 0.2, 1}, kind);
        light.shadow_map_pixels = 64;
        cast({.field = sampled(flat, 17)}, light);
        for (const HitPixel& at : hit_pixels(hits, camera)) {
            ASSERT_GE(share(at), 0);
            ASSERT_LE(share(at), 1);
        }
    }
}

TEST_F(Shadows, TakeTheirShareOfThePicture) {
    Scene scene{.field = floor_and_ball(ball)};
    scene.look.lights = {light_from(slanting, Shadow::None)};
    scene.look.material.ambient = 0;
    const Image lit = draw(scene);
    scene.look.lights[0] = light_from(slanting, Shadow::Soft);
    scene.look.lights[0].shadow_strength = 0.5;
    const Image beauty = draw(scene);
    renderer.draw(camera, size, size, {FrameImage::Shadow, FrameImage::Hit});
    shadow = renderer.read(FrameImage::Shadow);
    for (const HitPixel& at : hit_pixels(renderer.read(FrameImage::Hit), camera))
        for (int c = 0; c < 3; ++c) // 2^-9: a few roundings of the beauty's halves
            EXPECT_NEAR(beauty.pixel(at.x, at.y)[c],
                        lit.pixel(at.x, at.y)[c] * (0.5 + 0.5 * share(at)), 0x1p-9);
}

TEST_F(Shadows, CostNothingWhereTheyShowNothing) {
    Scene scene{.field = floor_and_ball(ball)};
    scene.look.lights = {light_from(slanting, Shadow::None)};
    const Image plain = draw(scene);
    const FrameReport of_plain = report;
    const Light soft = light_from(slanting, Shadow::Soft);
    const auto expect_nothing = [&](const char* why) {
        EXPECT_FALSE(pass("shadow map").ran || pass("shadow map").is_kept) << why;
        EXPECT_FALSE(pass("shadow").ran) << why;
        EXPECT_EQ(pass("shadow map").texture_bytes + pass("shadow").texture_bytes, 0) << why;
        EXPECT_EQ(report.programs_compiled, of_plain.programs_compiled) << why;
    };
    expect_nothing("no shadow");
    scene.look.lights = {soft};
    scene.look.lights[0].shadow_strength = 0;
    EXPECT_EQ(draw(scene).rgba, plain.rgba);
    EXPECT_EQ(report.image_bytes, of_plain.image_bytes);
    expect_nothing("strength 0");
    scene.look.lights = {light_from(slanting, Shadow::None), soft};
    scene.look.lights[1].colour = Vec3d::Zero();
    draw(scene);
    EXPECT_FALSE(pass("shadow").ran) << "black";
    scene.look.lights = {soft};
    const Camera at_scene = std::exchange(
        camera, {.eye_world = camera.eye_world, .target_world = 2 * camera.eye_world});
    draw(scene);
    EXPECT_FALSE(pass("shadow").ran || pass("shadow map").ran) << "the camera looks away";
    camera = at_scene;
    report = renderer.draw(camera, 2000, 2000, {FrameImage::Beauty},
                           PicturePart{.width = 32, .height = 32});
    EXPECT_FALSE(pass("shadow").ran || pass("shadow map").ran) << "nothing is in this part";
    scene.look.model = ShadingModel::Flat;
    draw(scene);
    EXPECT_FALSE(pass("shadow").ran || pass("shadow map").ran) << "unlit";
}

TEST_F(Shadows, AloneRunNoShading) {
    cast({.field = floor_and_ball(ball)}, light_from(slanting, Shadow::Soft));
    std::string ran;
    for (const PassReport& p : report.passes)
        if (p.ran) ran += p.name + ", ";
    EXPECT_EQ(ran, "raycast, gradient, shadow map, shadow, ");
    EXPECT_EQ(pass("shading").texture_bytes, 0);
}

TEST_F(Shadows, KeepTheirMapWhileLightAndSceneStay) {
    Scene scene{.field = floor_and_ball(ball)};
    cast(scene, light_from(slanting, Shadow::Soft));
    EXPECT_TRUE(pass("shadow map").ran);
    camera.eye_world = {-1, -2.5, 1.5};
    cast();
    EXPECT_TRUE(pass("shadow map").is_kept);
    EXPECT_FALSE(pass("shadow map").ran);
    EXPECT_GT(pass("shadow map").texture_bytes, 0);
    const Image kept = shadow;
    cast(scene, light_from(slanting, Shadow::Soft));
    EXPECT_TRUE(pass("shadow map").ran);
    EXPECT_EQ(shadow.rgba, kept.rgba);

    const auto expect_anew = [&](const char* why) {
        cast();
        EXPECT_TRUE(pass("shadow map").ran) << why;
        cast();
        EXPECT_TRUE(pass("shadow map").is_kept) << why;
    };
    Look look = renderer.look();
    look.lights[0].direction = {1, 0.3, 1};
    renderer.set_look(look);
    expect_anew("the light moves");
    renderer.set_iso(0.02);
    expect_anew("the surface moves");
    look.lights[0].shadow_map_pixels.reset();
    renderer.set_look(look);
    expect_anew("of the picture's size");
    EXPECT_LE(pass("shadow map").texture_bytes, 4 * size * size);
    size = 64;
    expect_anew("of another picture's size");
    look.lights[0].colour = {1, 0.5, 0.2};
    renderer.set_look(look);
    cast();
    EXPECT_TRUE(pass("shadow map").is_kept) << "colours do not matter";
    look.lights[0].is_in_view_space = true;
    renderer.set_look(look);
    expect_anew("a light of the camera's");
    camera.eye_world = {1, 2, 3};
    expect_anew("that turns with it");
    renderer.draw(camera, size, size, {FrameImage::Beauty, FrameImage::Hit});
    renderer.draw(camera, size, size, {FrameImage::Hit});
    expect_anew("it was let go");
}

TEST_F(Shadows, OfNoLightAreRefused) {
    Scene scene{.field = floor_and_ball(ball)};
    renderer.load(scene);
    EXPECT_THROW(renderer.draw(camera, size, size, {FrameImage::Shadow}), InputError);
    scene.look.lights = {light_from(Vec3d::Zero(), Shadow::Hard)};
    EXPECT_THROW(renderer.load(scene), InputError);
    scene.look.lights = {light_from(slanting, Shadow::Hard)};
    scene.look.lights[0].shadow_map_pixels = 3;
    EXPECT_THROW(renderer.load(scene), InputError);
}

} // namespace
} // namespace isocast::test
