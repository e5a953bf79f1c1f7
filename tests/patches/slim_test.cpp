// SLIM surfaces as they are drawn, against a double ray caster that blends what its rays meet.
// SPDX-License-Identifier: MPL-2.0
#include "../quadrics/random_primitives.h"
#include "../splats/splat_judge.h"
#include "quadrics/slim_splats.h"
#include "renderer_test_base.h"
#include "volume/errors.h"

#include <numbers>

namespace isocast::test {
namespace {

/// A piece whose function is around 0 near its centre, and may have planes.
SlimPatch some_patch(Random& random, double half_cube) {
    SlimPatch patch{.centre_world = random.in_cube(half_cube),
                    .radius_world = random.uniform(0.2, 0.8),
                    .normal = random.unit()};
    const double r = patch.radius_world;
    patch.height = {random.uniform(-0.2, 0.2) * r, random.uniform(-0.3, 0.3),
                    random.uniform(-0.3, 0.3),     random.uniform(-0.5, 0.5) / r,
                    random.uniform(-0.5, 0.5) / r, random.uniform(-0.5, 0.5) / r};
    patch.plane_count = static_cast<int>(random.uniform(0, 3));
    patch.is_any = patch.plane_count == 2 && random.coin();
    for (std::size_t k = 0; k < static_cast<std::size_t>(patch.plane_count); ++k)
        patch.planes[k] = {random.unit(), random.uniform(-0.2, 0.5) * r};
    return patch;
}

/// Paraboloids that touch a ball from within at points spread evenly: off by less than r^4 / 8 R^3.
SlimLevel ball_level(int count, double patch_radius, double radius = 1,
                     const Vec3d& centre_world = Vec3d::Zero()) {
    SlimLevel level{.patches = {},
                    .max_error_world = std::pow(patch_radius, 4) / (7.5 * std::pow(radius, 3))};
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count;
        const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const double rho = std::sqrt(1 - z * z);
        const Vec3d n(rho * std::cos(angle), rho * std::sin(angle), z);
        level.patches.push_back({.centre_world = centre_world + radius * n,
                                 .radius_world = patch_radius,
                                 .normal = n,
                                 .height = {0, 0, 0, -0.5 / radius, 0, -0.5 / radius}});
    }
    return level;
}

SlimSurface ball(int count = 400, double patch_radius = 0.3) {
    return {.levels = {ball_level(count, patch_radius)}, .is_closed = true};
}

struct Slims : RendererTest {
    Camera camera{.eye_world = {0.3, 0.4, 6}, .target_world = Vec3d::Zero(), .height_world = 4};
    Random random{5};

    /// error  of positions, by their distance from the eye
    Judgement expect_exact(const Primitives& primitives, double error = 1e-5, int width = 320,
                           int height = 240, const Cut& cut = {}) {
        const Judgement judgement = judge(renderer, primitives, camera, width, height, 0, cut);
        // A pixel in 1e5 lies within floats' roundings of an edge or a silhouette.
        EXPECT_LE(judgement.wrong, 1) << "at " << testing::PrintToString(judgement.pixels);
        EXPECT_LT(judgement.worst_error, error);
        return judgement;
    }
    Image drawn(const Primitives& primitives, FrameImage image, int size, const Look& look = {}) {
        renderer.load({.look = look, .primitives = std::make_shared<Primitives>(primitives)});
        renderer.draw(camera, size, size, {FrameImage::Hit, image});
        return renderer.read(image);
    }
};

TEST_F(Slims, OfOnePieceAreWhatTheRaysMeet) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (const bool is_closed : {false, true})
            for (int run = 0; run < 4; ++run) {
                Primitives many;
                for (int i = 0; i < 20; ++i)
                    many.slims.push_back(
                        {.levels = {{{some_patch(random, 1)}, 0.01}}, .is_closed = is_closed});
                EXPECT_GT(expect_exact(many).seen, 5000);
            }
    }
}

// Many pieces in a heap: which of them are one sheet is decided by roundings at few pixels.
TEST_F(Slims, BlendThePiecesOfTheFirstSheet) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (int run = 0; run < 4; ++run) {
            SlimSurface heap{.levels = {{{}, 0.02}}, .is_closed = run % 2 == 0};
            for (int i = 0; i < 40; ++i) {
                heap.levels[0].patches.push_back(some_patch(random, 0.6));
                heap.levels[0].patches.back().errors = random.uniform(1, 3);
            }
            const Primitives primitives{.slims = {heap}};
            const std::vector<SeenPrimitive> seen = cast_primitives(primitives, camera, 200, 200);
            const Image hits = drawn(primitives, FrameImage::Hit, 200);
            const Image normals = drawn(primitives, FrameImage::Gradient, 200);
            int met = 0, other = 0, turned = 0;
            for (std::size_t i = 0; i < seen.size(); ++i) {
                const bool is_hit = hits.rgba[4 * i + 3] != 0;
                if (seen[i].number < 0) {
                    other += is_hit;
                    continue;
                }
                ++met;
                const Ray ray =
                    camera_ray(camera, 200, 200, double(i % 200) + 0.5, double(i / 200) + 0.5);
                const Vec3d p =
                    ray.origin_world + seen[i].t * ray.direction_world - camera.eye_world;
                const auto of = [&](const Image& image) {
                    return Eigen::Map<const Eigen::Vector3f>(&image.rgba[4 * i]).cast<double>();
                };
                // A sheet of 0.02 more or less is another place; 1e-4 and 1e-3 lie far above
                // roundings where a ray does not graze a piece.
                other += !is_hit || (of(hits) - p).norm() > 1e-4;
                turned += (of(normals) - seen[i].normal).norm() > 1e-3;
            }
            EXPECT_GT(met, 5000);
            EXPECT_LE(other, met / 2000);
            EXPECT_LE(turned, met / 2000);
        }
    }
}

// A piece in front of another by more than both may be off is another sheet, which ends at its rim;
// if it may be off by so much, it fades into the other.
TEST_F(Slims, OfOneSheetFadeAtTheirRims) {
    const double error = 0.01;
    SlimSurface two{.levels = {{{{.radius_world = 2}, {.radius_world = 0.5}}, error}}};
    SlimPatch& before = two.levels[0].patches[1];
    before.centre_world = {0, 0, 2.5 * error};
    camera.projection = Projection::Orthographic;
    camera.eye_world = {0, 0, 6};
    constexpr int size = 200;
    for (const double errors : {1.0, 2.0}) {
        before.errors = errors;
        const Image hits = drawn({.slims = {two}}, FrameImage::Hit, size);
        double greatest_step = 0;
        for (std::size_t x = 1; x < size; ++x) { // along the middle
            const std::size_t at = 4 * (x + size * (size / 2));
            if (hits.rgba[at + 3] == 0 || hits.rgba[at - 1] == 0) continue;
            greatest_step =
                std::max(greatest_step, double(std::abs(hits.rgba[at + 2] - hits.rgba[at - 2])));
        }
        // The weight of the smaller falls by 2 / radius at most; a pixel is 0.02. A hundredth more
        // for roundings of floats; a tenth of it is seen, so that there is a rim.
        const double most = errors == 1 ? 2.5 * error : 2.5 * error * 2 * 0.02 / 0.5;
        EXPECT_LT(greatest_step, 1.01 * most);
        EXPECT_GT(greatest_step, 0.1 * most);
    }
}

TEST_F(Slims, AreTheSurfaceThatTheyCover) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        const SlimSurface surface = ball();
        const double error = surface.levels[0].max_error_world;
        const Primitives primitives{.slims = {surface}};
        const Image hits = drawn(primitives, FrameImage::Hit, 200);
        const Image normals = drawn(primitives, FrameImage::Gradient, 200);
        const Image curvatures = drawn(primitives, FrameImage::Curvature, 200);
        int seen = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            if (hits.rgba[i + 3] == 0) continue;
            ++seen;
            const Vec3d p = point_at(hits, i, camera);
            EXPECT_NEAR(p.norm(), 1, error);
            // A paraboloid's slope is off by r^3 / 2 at a piece's rim, where it has no weight.
            const Vec3d n = Eigen::Map<const Eigen::Vector3f>(&normals.rgba[i]).cast<double>();
            EXPECT_LT((n - p.normalized()).norm(), 0.0135);
            EXPECT_NEAR(n.norm(), 1, 1e-6);
            // The least of a paraboloid's at r from its apex is (1 + r^2)^(-3/2) > 1 - 1.5 r^2.
            for (const std::size_t k : {0, 1}) EXPECT_NEAR(curvatures.rgba[i + k], 1, 1.5 * 0.09);
        }
        EXPECT_GT(seen, 5000);
        // Nothing shows through, nor is missed: the ball a little smaller, and larger.
        for (const double side : {-1.0, 1.0}) {
            const auto limit = cast_primitives({.spheres = {{.radius_world = 1 + side * error}}},
                                               camera, 200, 200);
            for (std::size_t i = 0; i < limit.size(); ++i) {
                const bool is_hit = hits.rgba[4 * i + 3] != 0;
                const bool is_wrong =
                    side < 0 ? limit[i].number >= 0 && !is_hit : limit[i].number < 0 && is_hit;
                EXPECT_FALSE(is_wrong) << i;
            }
        }
    }
}

// alpha = 0: rays along a paraboloid's axis, and all through planes.
TEST_F(Slims, WithoutASquareAreExact) {
    camera.eye_world = {0, 0, 6};
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (const double bend : {1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-12, 0.0})
            for (const Vec3d& normal : {Vec3d(0, 0, 1), Vec3d(random.unit())}) {
                SCOPED_TRACE(bend);
                SlimPatch patch = some_patch(random, 0.5);
                patch.normal = normal;
                patch.plane_count = 0;
                for (const std::size_t k : {3, 4, 5}) patch.height[k] *= bend;
                EXPECT_GT(expect_exact({.slims = {{.levels = {{{patch}, 0.01}}}}}).seen, 100);
            }
    }
}

TEST_F(Slims, FarAwayAndFarFromTheOriginAreExact) {
    for (const double distance : {1e2, 1e3, 1e4}) {
        camera.eye_world = distance * Vec3d(0.3, 0.5, 1).normalized();
        camera.fov_y_degrees = 2 * std::atan(1.2 / distance) * 180 / std::numbers::pi;
        for (int run = 0; run < 5; ++run)
            EXPECT_GT(
                expect_exact({.slims = {{.levels = {{{some_patch(random, 0.5)}, 0.01}}}}}).seen,
                100);
        // The blend is of distances from the sheet, not from the eye.
        const Image hits = drawn({.slims = {ball()}}, FrameImage::Hit, 120);
        const double error = ball().levels[0].max_error_world;
        int seen = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            if (hits.rgba[i + 3] == 0) continue;
            ++seen;
            const Vec3d p = point_at(hits, i, camera);
            EXPECT_NEAR(p.norm(), 1, error + 2e-7 * distance); // roundings of the hit's own digits
        }
        EXPECT_GT(seen, 3000);
    }
    const Vec3d far = 1e6 * Vec3d(1, -2, 3);
    camera = {.eye_world = far + Vec3d(0.3, 0.4, 6), .target_world = far};
    for (int run = 0; run < 5; ++run) {
        SlimPatch patch = some_patch(random, 0.5);
        patch.centre_world += far;
        EXPECT_GT(expect_exact({.slims = {{.levels = {{{patch}, 0.01}}}}}).seen, 100);
    }
}

// Two faces that meet at 60 degrees, each clipped by the plane halfway: neither bends the other's
// normals, however near to the edge.
TEST_F(Slims, KeepACreaseSharp) {
    const double half = std::numbers::pi / 6; // from the plane between both faces
    SlimSurface wedge{.levels = {{{}, 1e-3}}};
    std::array<Vec3d, 2> normals;
    for (const int side : {-1, 1}) {
        const Vec3d n(side * std::cos(half), std::sin(half), 0);
        normals[side < 0 ? 0 : 1] = n;
        for (int i = -4; i <= 4; ++i) {
            SlimPatch patch{.centre_world = {0, 0, 0.25 * i}, .radius_world = 0.8, .normal = n};
            patch.plane_count = 1;
            patch.planes[0] = {Vec3d(side, 0, 0), 0};
            wedge.levels[0].patches.push_back(patch);
        }
    }
    camera = {.eye_world = {0.4, 5, 1}, .target_world = Vec3d::Zero(), .fov_y_degrees = 15};
    const Primitives primitives{.slims = {wedge}};
    const Image hits = drawn(primitives, FrameImage::Hit, 300);
    const Image gradients = drawn(primitives, FrameImage::Gradient, 300);
    std::array<int, 2> seen{};
    for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
        if (hits.rgba[i + 3] == 0) continue;
        const double x = camera.eye_world.x() + double(hits.rgba[i]);
        if (std::abs(x) < 1e-6) continue;
        const std::size_t side = x < 0 ? 0 : 1;
        ++seen[side];
        const Vec3d n = Eigen::Map<const Eigen::Vector3f>(&gradients.rgba[i]).cast<double>();
        EXPECT_LT((n - normals[side]).norm(), 1e-6) << x;
    }
    EXPECT_GT(seen[0], 3000);
    EXPECT_GT(seen[1], 3000);
    expect_exact(primitives);
}

TEST_F(Slims, AreAmongOthersByDepthAndCut) {
    for (const CutLook look : {CutLook::Inside, CutLook::Flat, CutLook::Capped}) {
        Primitives mixed{
            .spheres = {{.centre_world = {0.8, 0, 0.2}, .radius_world = 0.5}},
            .slims = {ball(),
                      {.levels = {ball_level(200, 0.3, 0.6, {-1, 0.3, 0.2})}, .is_closed = true}}};
        EXPECT_GT(expect_exact(mixed).seen, 5000);
        const Cut cut{.look = look, .planes = {{{0.2, 0, 1}, 0.3}}};
        EXPECT_GT(expect_exact(mixed, 1e-5, 320, 240, cut).seen, 5000);
    }
}

int drawn_of(const SlimSurface& surface, const SplatView& view) {
    return splats_of(Primitives{.slims = {surface}}, view).count(SplatKind::Slim);
}

TEST_F(Slims, ThatFaceAwayAreNotDrawn) {
    SplatView view{.space = {.eye_world = {0, 0, 6}},
                   .pixels_per_unit = 300,
                   .middle_pixels = {100, 100},
                   .width = 200,
                   .height = 200};
    const SlimSurface closed = ball();
    SlimSurface open = closed;
    open.is_closed = false;
    const int all = drawn_of(open, view);
    EXPECT_EQ(all, 400);
    EXPECT_LT(drawn_of(closed, view), 0.65 * all);
    EXPECT_GT(drawn_of(closed, view), 0.35 * all);
    // Where insides show, all are drawn.
    view.planes = {{{0, 0, 1}, 0.9}};
    EXPECT_GT(drawn_of(closed, view), 0.9 * all);
    view.planes.clear();
    view.space.eye_world = {0.5, 0.5, 0};
    EXPECT_EQ(drawn_of(closed, view), drawn_of(open, view));
    // A closed surface from outside is the same with all of them.
    for (int run = 0; run < 4; ++run) {
        camera.eye_world = random.uniform(3, 9) * random.unit();
        const Image of_closed = drawn({.slims = {closed}}, FrameImage::Hit, 160);
        const Image of_open = drawn({.slims = {open}}, FrameImage::Hit, 160);
        int differ = 0;
        for (std::size_t i = 0; i < of_open.rgba.size(); i += 4)
            differ += std::abs(of_open.rgba[i + 2] - of_closed.rgba[i + 2]) > 1e-3F;
        EXPECT_LT(differ, 30); // at the silhouette, where pieces end beyond it
    }
}

/// The finest 1/16 and 1/4 of the coarsest.
SlimSurface ball_of_levels() {
    SlimSurface surface = ball(1600, 0.15);
    surface.levels.push_back(ball_level(800, 0.2121));
    surface.levels.push_back(ball_level(400, 0.3));
    return surface;
}

// What is drawn errs by half a pixel, and moves with the camera by as little.
TEST_F(Slims, LevelsNeitherShowNorPop) {
    const SlimSurface surface = ball_of_levels();
    const Primitives primitives{.slims = {surface}};
    constexpr int size = 120;
    std::vector<float> before;
    std::vector<int> counts;
    for (double distance = 3; distance < 150; distance *= 1.02) {
        camera.eye_world = {0, 0, distance};
        camera.fov_y_degrees = 1;
        const double pixel = 2 * std::tan(std::numbers::pi / 360) * distance / size;
        const SplatView view{.space = picture_space(camera),
                             .pixels_per_unit = pixels_per_unit(camera, size),
                             .middle_pixels = {10000, 10000}, // of a picture of the whole ball
                             .width = 20000,
                             .height = 20000};
        counts.push_back(drawn_of(surface, view));
        const Image hits = drawn(primitives, FrameImage::Hit, size);
        std::vector<float> middle;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            if (hits.rgba[i + 3] == 0) continue;
            const Vec3d p = point_at(hits, i, camera);
            EXPECT_LT(std::abs(p.norm() - 1),
                      std::max(0.5 * pixel, surface.levels[0].max_error_world) + 4e-7 * distance);
        }
        // At the middle the surface is seen from straight above.
        const std::size_t at = 4 * (size / 2 + size * (size / 2));
        middle.push_back(static_cast<float>(distance) + hits.rgba[at + 2]);
        if (!before.empty()) {
            EXPECT_LT(std::abs(middle[0] - before[0]), 0.5 * pixel + 1e-5);
        }
        before = middle;
    }
    EXPECT_LT(counts.back(), 0.4 * counts.front());
    camera.projection = Projection::Orthographic;
    for (const double height : {0.1, 0.3, 1.0, 3.0, 30.0}) {
        camera.height_world = height;
        camera.eye_world = {0, 0, 3};
        expect_exact(primitives);
    }
}

TEST_F(Slims, CastShadowsAndHideTheSky) {
    const PatchMesh floor{
        .vertices_world = {{-2, -1.2, 2}, {2, -1.2, 2}, {2, -1.2, -2}, {-2, -1.2, -2}},
        .quads = {{0, 1, 2, 3}}};
    camera.eye_world = {1, 3, 6};
    const Vec3d light = Vec3d(0.4, 1, 0.3).normalized();
    constexpr int size = 160;
    const auto of_slim = shadows_and_sky(
        renderer, {.patches = {floor}, .slims = {ball_of_levels()}}, light, camera, size);
    const auto of_sphere =
        shadows_and_sky(renderer, {.spheres = {{}}, .patches = {floor}}, light, camera, size);
    int dark = 0, hidden = 0, other_shadow = 0, other_sky = 0, lit = 0, unlit = 0, sky = 0;
    for (std::size_t i = 0; i < of_sphere[2].rgba.size(); i += 4) {
        if (of_sphere[2].rgba[i + 3] == 0 || of_slim[2].rgba[i + 3] == 0) continue;
        const Vec3d p = point_at(of_slim[2], i, camera);
        if (p.y() > -1.19) { // on the ball: it neither shades itself nor hides its own sky
            const double slope = p.normalized().dot(light);
            if (slope > 0.2) ++lit, unlit += of_slim[0].rgba[i] == 0;
            if (p.y() > 0.3) sky += of_slim[1].rgba[i] < 1;
            continue;
        }
        dark += of_sphere[0].rgba[i] == 0;
        hidden += of_sphere[1].rgba[i] < 1;
        // A texel of the light's picture is less than 6 / size.
        const double inside = 1 - p.cross(light).norm();
        if (std::abs(inside) > 2 * 6.0 / size)
            other_shadow += (of_slim[0].rgba[i] == 0) != (inside > 0);
        other_sky += std::abs(of_sphere[1].rgba[i] - of_slim[1].rgba[i]) > 0.05F;
    }
    EXPECT_GT(dark, 500);
    EXPECT_GT(hidden, 500);
    EXPECT_EQ(other_shadow, 0);
    EXPECT_LT(other_sky, 20); // where a ray grazes the ball
    EXPECT_GT(lit, 1000);
    EXPECT_EQ(unlit, 0);
    EXPECT_EQ(sky, 0);
}

TEST_F(Slims, RunTheirPassesWhereThereAreSomeAlone) {
    const auto passes_of = [&](const Primitives& primitives, const ImageSet& wanted) {
        renderer.load({.primitives = std::make_shared<Primitives>(primitives)});
        const FrameReport report = renderer.draw(camera, 64, 64, wanted);
        std::vector<std::string> ran;
        for (const PassReport& pass : report.passes)
            if (pass.ran) ran.push_back(pass.name);
        return ran;
    };
    using Names = std::vector<std::string>;
    EXPECT_EQ(passes_of({.spheres = {{}}}, {FrameImage::Hit}), (Names{"splats", "raycast"}));
    EXPECT_EQ(passes_of({.slims = {ball()}}, {FrameImage::Hit}),
              (Names{"slim nearest", "slim hits", "splats", "raycast"}));
    EXPECT_EQ(passes_of({.slims = {ball()}}, {FrameImage::Beauty}),
              (Names{"slim nearest", "slim hits", "splat surfaces", "shading"}));
    EXPECT_EQ(
        passes_of({.spheres = {{}}, .slims = {ball()}}, {FrameImage::Hit, FrameImage::Curvature}),
        (Names{"slim nearest", "slim hits", "splats", "raycast", "curvature"}));
}

TEST_F(Slims, AreNotLitWhereTheyAreDrawn) {
    const auto primitives = std::make_shared<Primitives>(Primitives{.slims = {ball()}});
    EXPECT_THROW(
        renderer.load({.quality = {.splats = SplatShading::Direct}, .primitives = primitives}),
        InputError);
}

TEST_F(Slims, ArePlacedAsTheyAre) {
    SlimSurface heap{.levels = {{{}, 0.02}}};
    for (int i = 0; i < 10; ++i) heap.levels[0].patches.push_back(some_patch(random, 0.6));
    const Mat3d turn = random.rotation();
    const double scale = 1.7;
    const Vec3d shift(3, -4, 5);
    const Eigen::Affine3d to_world = Eigen::Translation3d(shift) * (scale * turn);
    const SlimSurface moved = placed(heap, to_world);
    for (int i = 0; i < 1000; ++i) {
        const auto k = static_cast<std::size_t>(i % 10);
        const SlimPatch& patch = heap.levels[0].patches[k];
        const Vec3d start = 2 * random.unit();
        const Vec3d way = patch.centre_world + 0.3 * random.unit() - start;
        const auto here = intersect(patch, start, way, false);
        const auto there =
            intersect(moved.levels[0].patches[k], to_world * start, to_world.linear() * way, false);
        ASSERT_EQ(here.size(), there.size());
        for (std::size_t h = 0; h < here.size(); ++h) {
            EXPECT_NEAR(here[h].t, there[h].t, 1e-9);
            EXPECT_LT((turn * here[h].normal - there[h].normal).norm(), 1e-9);
            EXPECT_NEAR(here[h].weight, there[h].weight, 1e-9);
        }
    }
}

// A share of directions' supports is tight: of a cap's own rim.
TEST_F(Slims, LieWithinTheirSupports) {
    for (int run = 0; run < 200; ++run) {
        const SlimPatch patch = some_patch(random, 1);
        const Mat3d axes = slim_axes(patch.normal);
        const Vec3d d = random.unit();
        for (int i = 0; i < 200; ++i) {
            const double u = random.uniform(-1, 1) * patch.radius_world;
            const double v = random.uniform(-1, 1) * patch.radius_world;
            const auto& h = patch.height;
            const Vec3d p = axes * Vec3d(u, v,
                                         h[0] + h[1] * u + h[2] * v + h[3] * u * u + h[4] * u * v +
                                             h[5] * v * v);
            if (p.norm() >= patch.radius_world || !is_kept(patch, p)) continue;
            EXPECT_LE(d.dot(p), support(patch, d) + 1e-12);
        }
        EXPECT_LE(support(patch, d), patch.radius_world);
    }
}

} // namespace
} // namespace isocast::test
