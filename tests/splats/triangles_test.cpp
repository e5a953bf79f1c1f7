// Triangles as they are drawn, against a double ray caster; where nothing else is said, not one
// pixel differs.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/sample_meshes.h"
#include "renderer_test_base.h"
#include "some_primitives.h"
#include "splat_judge.h"
#include "volume/errors.h"

#include <gmock/gmock.h>

namespace isocast::test {
namespace {

TriangleMesh one_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    return {.vertices_world = {a, b, c}, .triangles = {{0, 1, 2}}};
}

TriangleMesh drawn(const Mesh& mesh, double scale = 1, const Vec3d& at = Vec3d::Zero()) {
    TriangleMesh out{.vertices_world = mesh.vertices_world, .triangles = mesh.triangles};
    for (Vec3d& vertex : out.vertices_world) vertex = at + scale * vertex;
    return out;
}

/// Every triangle a mesh of its own, so that pixels tell which one they show.
std::vector<TriangleMesh> apart(const TriangleMesh& mesh) {
    std::vector<TriangleMesh> out;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto [a, b, c] = triangle_of(mesh, i).corners_world;
        out.push_back(one_triangle(a, b, c));
    }
    return out;
}

struct Triangles : RendererTest {
    Camera camera{.eye_world = {0.3, 0.4, 6}, .target_world = Vec3d::Zero()};
    Random random{11};

    /// error  of positions, by their distance from the eye: 1e-6 are a few roundings
    Judgement expect_exact(const Primitives& primitives, double error = 1e-6, int width = 320,
                           int height = 240) {
        const Judgement judgement = judge(renderer, primitives, camera, width, height);
        EXPECT_EQ(judgement.wrong, 0) << "at " << testing::PrintToString(judgement.pixels);
        EXPECT_LT(judgement.worst_error, error);
        return judgement;
    }
    int holes_in(const TriangleMesh& mesh, double inner_radius, int size) {
        return holes_before_ball(renderer, {.meshes = {mesh}}, inner_radius, camera, size);
    }
};

TEST_F(Triangles, AreWhatTheRaysMeetBesideQuadrics) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (int run = 0; run < 4; ++run) {
            Primitives some;
            for (int i = 0; i < 20; ++i)
                some.meshes.push_back(
                    one_triangle(random.in_cube(1), random.in_cube(1), random.in_cube(1)));
            EXPECT_GT(expect_exact(some).seen, 5000);
            Primitives with_quadrics = some_quadrics(random, 5, 0.2);
            with_quadrics.meshes = some.meshes;
            expect_exact(with_quadrics, 1e-5); // as quadrics of these kinds have it
        }
    }
}

TEST_F(Triangles, OfAMeshAreEachInTheirPixels) {
    // 800 triangles of the knot that pixels see, and 2,048 of a sphere.
    for (const TriangleMesh& mesh :
         {drawn(sample_mesh("knot"), 0.3), drawn(subdivided_sphere(3), 1.2)}) {
        const Judgement judgement = judge(renderer, {.meshes = apart(mesh)}, camera, 320, 240);
        // A pixel in 1e4 lies within 1e-5 of a pixel of an edge: floats' roundings across 320.
        EXPECT_LE(judgement.wrong, 1) << testing::PrintToString(judgement.pixels);
        EXPECT_GT(judgement.seen, 8000);
        EXPECT_LT(judgement.worst_error, 1e-6);
    }
}

TEST_F(Triangles, AcrossTheEyesPlaneAndAroundTheEye) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        const Vec3d eye = camera.eye_world;
        expect_exact({.meshes = {one_triangle(eye + Vec3d(0.3, -1, 2), eye + Vec3d(0.5, -1, 3),
                                              eye + Vec3d(-0.2, -0.6, -5))}});
        expect_exact({.meshes = {one_triangle(eye + Vec3d(-40, -1, 30), eye + Vec3d(50, -1, 20),
                                              eye + Vec3d(0.1, -0.2, -20))}});
        // One vertex in the eye's plane, to within roundings.
        expect_exact(
            {.meshes = {one_triangle(eye + Vec3d(0.3, -1, 1e-17), eye + Vec3d(0.5, 0.2, -3),
                                     eye + Vec3d(-0.7, 0.4, -2))}});
        // Behind it.
        EXPECT_EQ(
            expect_exact({.meshes = {one_triangle(eye + Vec3d(0.3, -1, 1), eye + Vec3d(0.5, 0.2, 3),
                                                  eye + Vec3d(-0.7, 0.4, 2))}})
                .seen,
            0);
        // From within a mesh its inside is all around.
        camera.target_world = eye + Vec3d(1, 2, -1.5);
        const Judgement within = expect_exact({.meshes = apart(drawn(octahedron(), 2, eye))});
        if (projection ==
            Projection::Perspective) { // parallel rays start in a plane, beside it too
            EXPECT_EQ(within.seen, 320 * 240);
        }
        camera.target_world = Vec3d::Zero();
    }
}

TEST_F(Triangles, SmallByTheirDistanceAreAsExactAsNear) {
    for (const double ratio : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
        const double distance = 1 / ratio;
        camera.eye_world = distance * Vec3d(0.3, 0.5, 1).normalized();
        camera.fov_y_degrees = 2 * std::atan(1.2 / distance) * 180 / std::acos(-1.0);
        SCOPED_TRACE(ratio);
        // The side that faces the eye: of two sides that are nearer to each other than depths
        // round, 1e-7 of their distance, either may show.
        std::vector<TriangleMesh> faces = apart(drawn(octahedron()));
        std::erase_if(faces, [&](const TriangleMesh& face) {
            return area_normal(triangle_of(face, 0)).dot(camera.eye_world) < 0;
        });
        EXPECT_GT(expect_exact({.meshes = faces}, 1e-6, 121, 121).seen, 3000);
    }
}

TEST_F(Triangles, FarFromTheWorldsOrigin) {
    const Vec3d far(1e7, -2e7, 3e7);
    camera.eye_world += far;
    camera.target_world += far;
    Primitives some;
    for (int i = 0; i < 30; ++i)
        some.meshes.push_back(one_triangle(far + random.in_cube(1), far + random.in_cube(1),
                                           far + random.in_cube(1)));
    EXPECT_GT(expect_exact(some).seen, 5000);
}

TEST_F(Triangles, HugeOnesBehindASmallOne) {
    // A ground of 1e7, seen from 1 above it, and a triangle that stands on it.
    camera.eye_world = {0, 1, 0};
    camera.target_world = {0.1, 0.9, -1};
    const Primitives some{.meshes = {one_triangle({-1e7, 0, 1e7}, {1e7, 0, 1e7}, {0, 0, -1e7}),
                                     one_triangle({-1, 0, -4}, {1, 0, -4}, {0, 1, -4})}};
    // Hits near the horizon are as far off as a rounding of the ray's slope takes them, but on the
    // ground.
    EXPECT_GT(expect_exact(some).seen, 30000);
}

TEST_F(Triangles, EdgeOnOnesShowNothingButTheirRoundings) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera = {.eye_world = {0, 0, 5}, .target_world = Vec3d::Zero(), .projection = projection};
        // In the plane y = 0 through the eye, which passes between rows of an even number of them,
        // and along a row of an odd one.
        const TriangleMesh flat = one_triangle({-1, 0, 1}, {1, 0, 0.5}, {0.2, 0, -1});
        EXPECT_EQ(expect_exact({.meshes = {flat}}).seen, 0);
        const Image hits = [&] {
            renderer.load(
                {.primitives = std::make_shared<Primitives>(Primitives{.meshes = {flat}})});
            renderer.draw(camera, 101, 101, {FrameImage::Hit});
            return renderer.read(FrameImage::Hit);
        }();
        for (int y = 0; y < 101; ++y)
            for (int x = 0; x < 101; ++x) {
                const float* hit = hits.pixel(x, y);
                if (hit[3] == 0) continue;
                EXPECT_EQ(y, 50);
                EXPECT_GE(hit[2] + 5, -1.00001); // within the triangle's depths
                EXPECT_LE(hit[2] + 5, 1.00001);
            }
    }
}

TEST_F(Triangles, WithoutAreaAreSkipped) {
    Primitives some{.meshes = {one_triangle({-1, -1, 0}, {0, 0, 0}, {1, 1, 0}),
                               one_triangle({0.5, 0.5, 0}, {0.5, 0.5, 0}, {-1, 0.2, 0}),
                               one_triangle({0, 0, 1}, {0, 0, 1}, {0, 0, 1})}};
    EXPECT_EQ(expect_exact(some).seen, 0);
    some.meshes.push_back(one_triangle({-1, -1, -1}, {1, -1, -1}, {0, 1, -1}));
    EXPECT_GT(expect_exact(some).seen, 1000);
}

TEST_F(Triangles, OfAClosedMeshLeaveNoHole) {
    const TriangleMesh sphere = drawn(subdivided_sphere(4)); // within 0.995 of its radius
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera = {.target_world = Vec3d::Zero(), .projection = projection, .height_world = 2.2};
        for (int run = 0; run < 20; ++run) {
            camera.eye_world = 5 * random.in_cube(1).normalized();
            EXPECT_EQ(holes_in(sphere, 0.99, 300), 0);
        }
        // Edges along rows and columns of pixels, and vertices in their middles.
        for (const Vec3d& direction : {Vec3d(0, 0, 1), Vec3d(0, 0, -1), Vec3d(1, 0, 0)})
            for (const int size : {100, 101}) {
                camera.eye_world = 5 * direction;
                EXPECT_EQ(holes_in(drawn(octahedron()), 0.57, size), 0);
                EXPECT_EQ(holes_in(sphere, 0.99, size), 0);
            }
    }
}

TEST_F(Triangles, AMillionOfThemLeaveNoHole) {
    camera = {.eye_world = {1, 2, 5}, .target_world = {0.02, 0, 0}};
    EXPECT_EQ(holes_in(drawn(subdivided_sphere(8)), 0.9999, 512), 0); // 2^19 triangles
}

TEST_F(Triangles, PartsAreTheWholePicture) {
    // An octahedron along the axes, whose edges pass through pixels' middles, and a knot.
    camera = {.eye_world = {0, 0, 5}, .target_world = Vec3d::Zero()};
    Primitives some{.meshes = apart(drawn(octahedron()))};
    some.meshes.push_back(drawn(sample_mesh("knot"), 0.2, {0.5, 0.5, 0.3}));
    number_by_colour(some);
    Look look;
    look.lights[0].shadow = Shadow::Soft;
    renderer.load({.look = look, .primitives = std::make_shared<Primitives>(some)});
    const int size = 101;
    const ImageSet images{FrameImage::Beauty, FrameImage::Hit, FrameImage::SplatColour};
    renderer.draw(camera, size, size, images);
    const std::array kinds{FrameImage::Beauty, FrameImage::Hit, FrameImage::SplatColour};
    std::array<Image, 3> whole;
    for (std::size_t k = 0; k < 3; ++k) whole[k] = renderer.read(kinds[k]);
    for (const PicturePart& part : {PicturePart{.x = 3, .y = 17, .width = 61, .height = 44},
                                    PicturePart{.x = 50, .y = 50, .width = 51, .height = 51},
                                    PicturePart{.x = 50, .y = 0, .width = 1, .height = 101}}) {
        renderer.draw(camera, size, size, images, part);
        for (std::size_t k = 0; k < 3; ++k) {
            const Image drawn = renderer.read(kinds[k]);
            for (int y = 0; y < part.height; ++y)
                for (int x = 0; x < part.width; ++x)
                    for (int channel = 0; channel < 4; ++channel)
                        ASSERT_EQ(drawn.pixel(x, y)[channel],
                                  whole[k].pixel(x + part.x, y + part.y)[channel])
                            << x << ", " << y << ": " << name_of(kinds[k]);
        }
    }
}

TEST_F(Triangles, HaveTheFacesNormalsOrThoseBetweenTheirCorners) {
    TriangleMesh sphere = drawn(subdivided_sphere(3));
    const auto images = [&] {
        renderer.load({.primitives = std::make_shared<Primitives>(Primitives{.meshes = {sphere}})});
        renderer.draw(camera, 160, 160, {FrameImage::Hit, FrameImage::Gradient});
        return std::pair{renderer.read(FrameImage::Hit), renderer.read(FrameImage::Gradient)};
    };
    const auto worst_angle = [&](const Image& hits, const Image& normals, auto normal_at) {
        double worst = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            if (hits.rgba[i + 3] == 0) continue;
            const Vec3d p =
                camera.eye_world + Vec3d(hits.rgba[i], hits.rgba[i + 1], hits.rgba[i + 2]);
            const Vec3d n(normals.rgba[i], normals.rgba[i + 1], normals.rgba[i + 2]);
            EXPECT_NEAR(n.norm(), 1, 1e-6);
            EXPECT_EQ(normals.rgba[i + 3], 1); // no thin thing
            worst = std::max(worst, (n - normal_at(i / 4, p)).norm());
        }
        return worst;
    };
    const std::vector<SeenPrimitive> seen = cast_primitives({.meshes = {sphere}}, camera, 160, 160);
    const auto [hits, flat] = images();
    EXPECT_LT(worst_angle(hits, flat, [&](std::size_t i, const Vec3d&) { return seen[i].normal; }),
              1e-6);
    // With the sphere's normals at corners those between are the sphere's to second order; where
    // they turn away from the eye they are mirrored, by twice a face's tilt at most.
    double tilt = 0;
    for (std::size_t i = 0; i < sphere.triangles.size(); ++i)
        for (const Vec3d& corner : triangle_of(sphere, i).corners_world) {
            tilt =
                std::max(tilt, (corner - area_normal(triangle_of(sphere, i)).normalized()).norm());
            sphere.normals_world.push_back(corner.cast<float>());
        }
    const auto [same_hits, smooth] = images();
    EXPECT_EQ(same_hits.rgba, hits.rgba);
    const auto outward = [](std::size_t, const Vec3d& p) { return Vec3d(p.normalized()); };
    EXPECT_LT(worst_angle(hits, smooth, outward), 2 * tilt);
    EXPECT_GT(worst_angle(hits, flat, outward), 0.5 * tilt);
    EXPECT_LT(
        worst_angle(
            hits, smooth,
            [&](std::size_t i, const Vec3d& p) -> Vec3d {
                const Vec3d normal = p.normalized();
                const Vec3d view = (p - camera.eye_world).normalized();
                return normal.dot(view) < -tilt
                           ? normal
                           : Eigen::Map<const Eigen::Vector3f>(&smooth.rgba[4 * i]).cast<double>();
            }),
        tilt * tilt);
    for (std::size_t i = 0; i < seen.size(); ++i) // none turns away
        if (seen[i].number == 0) {
            const Eigen::Map<const Eigen::Vector3f> n(&smooth.rgba[4 * i]);
            const Eigen::Map<const Eigen::Vector3f> p(&hits.rgba[4 * i]);
            EXPECT_LT(n.dot(p), 1e-5);
        }
}

TEST_F(Triangles, AreFlatToCurvatures) {
    renderer.load({.primitives = std::make_shared<Primitives>(
                       Primitives{.meshes = {drawn(subdivided_sphere(2))}})});
    renderer.draw(camera, 80, 80, {FrameImage::Hit, FrameImage::Curvature, FrameImage::Direction});
    const Image hits = renderer.read(FrameImage::Hit);
    const Image curvatures = renderer.read(FrameImage::Curvature);
    for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
        EXPECT_EQ(curvatures.rgba[i], 0);
        EXPECT_EQ(curvatures.rgba[i + 1], 0);
        EXPECT_EQ(curvatures.rgba[i + 3] != 0, hits.rgba[i + 3] != 0);
    }
}

TEST_F(Triangles, CastShadowsAlongTheLightsRays) {
    // A floor, and a triangle above it.
    TriangleMesh floor{.vertices_world = {{-2, 0, -2}, {2, 0, -2}, {2, 0, 2}, {-2, 0, 2}},
                       .triangles = {{0, 2, 1}, {0, 3, 2}}};
    const Triangle above{{Vec3d(-0.7, 0.8, -0.5), Vec3d(0.8, 0.9, -0.2), Vec3d(0.1, 0.7, 0.8)}};
    const auto& [a, b, c] = above.corners_world;
    const Primitives scene{.meshes = {floor, one_triangle(a, b, c)}};
    const Vec3d light = Vec3d(0.4, 1, 0.3).normalized();
    camera.eye_world = {1, 4, 5};
    constexpr int size = 200;
    constexpr double texel = 6.0 / size; // less than the light's view of the floor by 200
    const auto is_lit = [&](const Vec3d& p) -> std::optional<bool> {
        // Distances of the way to the light from the triangle's edges, inwards.
        double inside = std::numeric_limits<double>::infinity();
        const std::array corners{a, b, c};
        const double side = light.dot((b - a).cross(c - a)) > 0 ? 1 : -1;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d edge = corners[(k + 1) % 3] - corners[k];
            inside = std::min(inside, side * light.cross(edge).normalized().dot(p - corners[k]));
        }
        if (std::abs(inside) < 2 * texel) return std::nullopt;
        return inside < 0;
    };
    const auto [dark, lit] = judge_hard_shadows(renderer, scene, light, camera, size, 0, is_lit);
    EXPECT_GT(dark, 500);
    EXPECT_GT(lit, 5000);
}

TEST_F(Triangles, RunTwoProgramsForHitsAndNeedNoNormalsUnlessGiven) {
    const auto report_of = [&](const TriangleMesh& mesh) {
        Renderer other(*context, shader_folder);
        other.load({.primitives = std::make_shared<Primitives>(Primitives{.meshes = {mesh}})});
        return other.draw(camera, 64, 64, {FrameImage::Hit});
    };
    TriangleMesh mesh = drawn(octahedron());
    const FrameReport flat = report_of(mesh);
    EXPECT_EQ(flat.programs_compiled, 2);
    EXPECT_EQ(flat.field_bytes, 0);
    mesh.normals_world.resize(24, Eigen::Vector3f::UnitX());
    EXPECT_EQ(report_of(mesh).splat_bytes, flat.splat_bytes + 24 * 16);
}

TEST_F(Triangles, ThatCannotBeDrawnAreRefusedByTheirIndex) {
    const auto load = [&](const TriangleMesh& mesh) {
        renderer.load({.primitives = std::make_shared<Primitives>(
                           Primitives{.meshes = {drawn(octahedron()), mesh}})});
    };
    TriangleMesh mesh = drawn(octahedron());
    for (const double wrong : {double(NAN), double(INFINITY)}) {
        mesh.vertices_world[4].y() = wrong;
        EXPECT_THAT([&] { load(mesh); }, testing::ThrowsMessage<InputError>(
                                             testing::HasSubstr("mesh 1: vertex 4 is not finite")));
    }
    mesh = drawn(octahedron());
    mesh.triangles[3][1] = 6;
    EXPECT_THAT([&] { load(mesh); }, testing::ThrowsMessage<InputError>(testing::HasSubstr(
                                         "mesh 1: triangle 3: there is no vertex 6")));
    mesh = drawn(octahedron());
    mesh.normals_world.resize(3);
    EXPECT_THAT([&] { load(mesh); }, testing::ThrowsMessage<InputError>(
                                         testing::HasSubstr("mesh 1: 3 normals for 24 corners")));
    EXPECT_THROW(
        renderer.load({.primitives = std::make_shared<Primitives>(Primitives{.meshes = {{}}})}),
        InputError); // nothing at all
}

} // namespace
} // namespace isocast::test
