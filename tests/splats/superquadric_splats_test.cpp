// Superquadrics as they are drawn, against the double ray caster.
// SPDX-License-Identifier: MPL-2.0
#include "../quadrics/random_primitives.h"
#include "../volume/temporary_folder.h"
#include "filtering/curvature.h"
#include "quadrics/superquadric.h"
#include "renderer_test_base.h"
#include "splat_judge.h"

#include <fstream>

namespace isocast::test {
namespace {

/// Of N: the shader's body is the true one, grown or shrunk by less. 8 roundings end its search,
/// 13 are those of two powers each by logarithm and exponential, 11 those of the ray's place in
/// local coordinates.
constexpr double silhouette = 32 * 0x1p-23;

struct SuperquadricSplat : RendererTest {
    Camera camera{.eye_world = {0.3, 0.4, 6}, .target_world = Vec3d::Zero()};
    Random random{5};

    /// From thin needles and plates to boxes; a third of the exponents are the sharpest.
    Superquadric some() {
        const auto exponent = [&] { return random.coin() ? random.log_uniform(0.05, 1) : 0.05; };
        return {.centre_world = random.in_cube(1),
                .axes_world = random.rotation() * Vec3d(random.log_uniform(0.05, 0.6),
                                                        random.log_uniform(0.05, 0.6),
                                                        random.log_uniform(0.05, 0.6))
                                                      .asDiagonal(),
                .alpha = exponent(),
                .beta = exponent()};
    }
    Primitives many(int count) {
        Primitives primitives;
        for (int i = 0; i < count; ++i) primitives.superquadrics.push_back(some());
        return primitives;
    }
    /// error  of positions, by their distance from the eye: the silhouette's share of half the
    ///        distance at most, and a few roundings
    Judgement expect_exact(const Primitives& primitives, int width = 320, int height = 240,
                           double error = 2e-6) {
        const Judgement judgement = judge(renderer, primitives, camera, width, height, silhouette);
        EXPECT_EQ(judgement.wrong, 0) << "at " << testing::PrintToString(judgement.pixels);
        EXPECT_LT(judgement.worst_error, error);
        return judgement;
    }
};

TEST_F(SuperquadricSplat, IsWhatTheRaysMeet) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (int run = 0; run < 6; ++run) EXPECT_GT(expect_exact(many(12)).seen, 1000);
    }
}

TEST_F(SuperquadricSplat, OfTheSharpestAndTheFlattestIsWhatTheRaysMeet) {
    for (const auto& [alpha, beta] :
         {std::pair(0.05, 0.05), std::pair(1.0, 0.05), std::pair(0.05, 1.0), std::pair(1.0, 1.0)})
        for (const Vec3d& lengths :
             {Vec3d(1, 1, 1), Vec3d(1, 0.7, 1e-3), Vec3d(1e-3, 1e-3, 1), Vec3d(1, 1e-5, 0.5)}) {
            Primitives primitives;
            for (int i = 0; i < 6; ++i)
                primitives.superquadrics.push_back(
                    {.centre_world = random.in_cube(1.2),
                     .axes_world = random.rotation() * (0.5 * lengths).asDiagonal(),
                     .alpha = alpha,
                     .beta = beta});
            SCOPED_TRACE(testing::PrintToString(std::pair(alpha, beta)));
            expect_exact(primitives);
        }
}

// The view's axis runs along faces, edges and axes of boxes.
TEST_F(SuperquadricSplat, AlongItsFacesAndEdgesIsWhatTheRaysMeet) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera = {.eye_world = {0, 0, 5}, .target_world = Vec3d::Zero(), .projection = projection};
        Primitives boxes;
        for (const double x : {-1.0, 0.0, 0.5})
            boxes.superquadrics.push_back({.centre_world = {x, 0.5 * x, 0},
                                           .axes_world = Vec3d(0.25, 0.5, 1).asDiagonal(),
                                           .alpha = 0.05,
                                           .beta = 0.05});
        expect_exact(boxes, 321, 241);
    }
}

TEST_F(SuperquadricSplat, AroundTheEyeAndAcrossItsPlaneIsWhatTheRaysMeet) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (const Vec3d& offset : {Vec3d(0, 0.1, 0.3), Vec3d(0.9, 0, 0.1), Vec3d(0, -1.1, 0)}) {
            Superquadric around = some();
            around.centre_world = camera.eye_world + offset;
            around.axes_world = random.rotation() * Vec3d(1, 0.8, 1.5).asDiagonal();
            // Seen from a fifth of its size.
            expect_exact({.superquadrics = {around}}, 320, 240, 2e-5);
        }
    }
}

TEST_F(SuperquadricSplat, SmallByItsDistanceIsAsExactAsNear) {
    for (const double ratio : {1e-1, 1e-3, 1e-6}) {
        camera.eye_world = Vec3d(0.3, 0.5, 1).normalized() / ratio;
        // 2.4 semi-axes from top to bottom.
        camera.fov_y_degrees = 2 * std::atan(1.2 * ratio) * 180 / std::acos(-1.0);
        SCOPED_TRACE(ratio);
        expect_exact({.superquadrics = {{.axes_world = Vec3d(1, 0.5, 0.3).asDiagonal(),
                                         .alpha = 0.3,
                                         .beta = 0.1}}},
                     120, 120);
    }
}

// Each is either in front of all others or hidden by them: by discs within, too.
TEST_F(SuperquadricSplat, BehindManyOthersIsStillWhatTheRaysMeet) {
    Primitives primitives = many(1000);
    for (Superquadric& s : primitives.superquadrics)
        s.axes_world = random.rotation() * Vec3d(0.2, 0.17, 0.15).asDiagonal();
    EXPECT_GT(expect_exact(primitives).seen, 20000);
    const auto everything =
        SplatsOnGpu(primitives, {}, camera, 320, 240, {.width = 320, .height = 240});
    EXPECT_LT(everything.kinds.at(0).count, 950); // discs hide some
}

TEST_F(SuperquadricSplat, CurvaturesAreThoseOfTheNorm) {
    Primitives primitives = many(12);
    for (Superquadric& s : primitives.superquadrics) s.alpha = std::max(s.alpha, s.beta);
    number_by_colour(primitives);
    renderer.load({.primitives = std::make_shared<Primitives>(primitives)});
    const int size = 200;
    renderer.draw(camera, size, size,
                  {FrameImage::SplatColour, FrameImage::Gradient, FrameImage::Curvature,
                   FrameImage::Direction});
    const Image colours = renderer.read(FrameImage::SplatColour);
    const Image gradients = renderer.read(FrameImage::Gradient);
    const Image curvatures = renderer.read(FrameImage::Curvature);
    const Image directions = renderer.read(FrameImage::Direction);
    const std::vector<SeenPrimitive> seen = cast_primitives(primitives, camera, size, size);
    int compared = 0;
    int directed = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        EXPECT_EQ(curvatures.rgba[4 * i + 3] != 0, number_of_colour(&colours.rgba[4 * i]) >= 0);
        if (seen[i].number < 0 || number_of_colour(&colours.rgba[4 * i]) != seen[i].number)
            continue;
        const Superquadric& body =
            primitives.superquadrics[static_cast<std::size_t>(seen[i].number)];
        const Ray ray =
            camera_ray(camera, size, size, double(i % size) + 0.5, double(i / size) + 0.5);
        const Vec3d p = ray.origin_world + seen[i].t * ray.direction_world;
        const QuadricDerivatives d = derivatives(body, p);
        const Curvatures k = principal_curvatures(d.gradient, d.hessian);
        // A float's hit is off by 1e-6 of the eye's distance 6, grazing the more by the cosine: so
        // many local units, of which an edge's bend is 1/40, and the bend changes as much.
        const double cosine = std::abs(seen[i].normal.dot(ray.direction_world.normalized()));
        const double local = 6e-6 * body.axes_world.inverse().norm() / cosine;
        const double allowed = local * 80;
        if (allowed > 0.05) continue;
        const Vec3d normal =
            Eigen::Map<const Eigen::Vector3f>(&gradients.rgba[4 * i]).cast<double>();
        EXPECT_LT((normal.normalized() - seen[i].normal).norm(), allowed);
        // The curvature's own scale, everywhere on the body: flat faces have roundings of it.
        const double scale = std::max({std::abs(k.k1), std::abs(k.k2), d.gradient.norm()});
        EXPECT_NEAR(curvatures.rgba[4 * i], k.k1, allowed * scale)
            << body.alpha << " " << body.beta;
        EXPECT_NEAR(curvatures.rgba[4 * i + 1], k.k2, allowed * scale);
        ++compared;
        if (k.k1 - k.k2 < 0.2 * scale) continue;
        const Vec3d direction =
            Eigen::Map<const Eigen::Vector3f>(&directions.rgba[4 * i]).cast<double>();
        // Turned by a change of the Hessian over the difference of its eigenvalues.
        EXPECT_GT(std::abs(direction.dot(k.direction1)), std::cos(5 * allowed + 1e-3));
        ++directed;
    }
    EXPECT_GT(compared, 3000);
    EXPECT_GT(directed, 1000);
}

TEST_F(SuperquadricSplat, HardShadowsAreThoseOfRaysToTheLight) {
    Primitives scene{.cylinders = {{.a_world = {0, -1, 0},
                                    .b_world = {0, -0.6, 0},
                                    .radius_world = 1.2,
                                    .is_capped = true}},
                     .superquadrics = {{.centre_world = {0.1, 0, 0},
                                        .axes_world = Mat3d::Identity() * 0.35,
                                        .alpha = 0.1,
                                        .beta = 0.1}}};
    const Vec3d light = Vec3d(0.4, 1, 0.3).normalized();
    camera.eye_world = {1, 2.5, 4};
    constexpr int size = 160;
    // A texel is 2.4 / 160 of the world, and bilinear weights reach one and a half of them.
    constexpr double texel = 3.0 / size;
    const auto is_lit = [&](const Vec3d& p) -> std::optional<bool> {
        const auto is_dark = [&](double grown) {
            Superquadric body = scene.superquadrics[0];
            body.axes_world *= (0.35 + grown) / 0.35;
            return intersect(body, p, light).has_value();
        };
        if (is_dark(2 * texel) != is_dark(-2 * texel)) return std::nullopt;
        return !is_dark(0);
    };
    const auto [dark, lit] = judge_hard_shadows(renderer, scene, light, camera, size, 0, is_lit);
    EXPECT_GT(dark, 100);
    EXPECT_GT(lit, 1000);
}

// A box that is turned: lines where it ends and along the edges that show, none on its faces.
TEST_F(SuperquadricSplat, OutlinesAreItsSilhouetteAndItsEdges) {
    const Primitives box{.superquadrics = {{.alpha = 0.05, .beta = 0.05}}};
    Look look;
    look.effects.outlines.strength = 1;
    renderer.load({.look = look, .primitives = std::make_shared<Primitives>(box)});
    camera.eye_world = {5, 4, 8}; // so far that an edge is no wider than a pixel or two
    const int size = 160;
    renderer.draw(camera, size, size, {FrameImage::Outlines});
    const Image lines = renderer.read(FrameImage::Outlines);
    const std::vector<SeenPrimitive> seen = cast_primitives(box, camera, size, size);
    int edges = 0;
    int faces = 0;
    for (int y = 1; y < size - 1; ++y)
        for (int x = 1; x < size - 1; ++x) {
            // The greatest turn of the normal around the pixel, 2 where the box ends.
            double turn = 0;
            const auto at = [&](int i, int j) -> const SeenPrimitive& {
                return seen[static_cast<std::size_t>(j * size + i)];
            };
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                    turn =
                        std::max(turn, at(x + dx, y + dy).number != at(x, y).number
                                           ? 2
                                           : (at(x + dx, y + dy).normal - at(x, y).normal).norm());
            const float line = lines.pixel(x, y)[3];
            const bool is_end = turn == 2 && at(x, y).number == 0;
            EXPECT_TRUE(is_end ? line > 0.5F : turn > 0.01 || line == 0) << x << " " << y;
            edges += turn < 2 && line > 0.5F;
            faces += turn < 0.01 && at(x, y).number == 0;
        }
    EXPECT_GT(edges, 50);
    EXPECT_GT(faces, 500);
}

// Their code is no part of other kinds' programs: these compile where it is an error.
TEST_F(SuperquadricSplat, IsNoPartOfOtherKindsPrograms) {
    const TemporaryFolder folder;
    std::filesystem::copy(shader_folder, folder / "shaders",
                          std::filesystem::copy_options::recursive);
    std::ofstream(folder / "shaders/quadrics/superquadric.glsl") << "#error\n";
    Renderer poisoned(*context, folder / "shaders");
    Primitives others{.spheres = {random.sphere()},
                      .ellipsoids = {random.ellipsoid()},
                      .cylinders = {random.cylinder()},
                      .cones = {random.cone()},
                      .quadrics = {random.clipped_quadric()}};
    const ImageSet images{FrameImage::Beauty, FrameImage::Curvature};
    poisoned.load({.primitives = std::make_shared<Primitives>(others)});
    EXPECT_NO_THROW(poisoned.draw(camera, 40, 40, images));
    others.superquadrics.push_back(some());
    poisoned.load({.primitives = std::make_shared<Primitives>(others)});
    EXPECT_THROW(poisoned.draw(camera, 40, 40, images), gl::GlError);
}

} // namespace
} // namespace isocast::test
