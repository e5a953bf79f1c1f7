// Bilinear patches as they are drawn, against a double ray caster: no pixel misses one.
// SPDX-License-Identifier: MPL-2.0
#include "../quadrics/quad_cube.h"
#include "../quadrics/random_primitives.h"
#include "../splats/splat_judge.h"
#include "../volume/temporary_folder.h"
#include "gl/program.h"
#include "quadrics/patch_splats.h"
#include "raycaster/splat_passes.h"
#include "renderer_test_base.h"
#include "volume/errors.h"

#include <gmock/gmock.h>

#include <fstream>
#include <numbers>

namespace isocast::test {
namespace {

PatchMesh one_patch(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    return {.vertices_world = {a, b, c, d}, .quads = {{0, 1, 2, 3}}};
}

/// A cube's faces in cells, its vertices on the unit sphere but for `noise` of a cell's size: faces
/// are twisted, and neighbours share vertices.
PatchMesh quad_sphere(int cells, double noise, Random& random) {
    return quad_cube(cells, [&](const Vec3d& p) {
        return Vec3d(p.normalized() + random.in_cube(noise / cells));
    });
}

/// Each patch from -share to 1 + share.
Primitives grown(Primitives primitives, double share) {
    for (PatchMesh& mesh : primitives.patches) {
        PatchMesh out{.vertices_world = {}, .quads = {}, .colour = mesh.colour};
        for (std::size_t i = 0; i < mesh.quads.size(); ++i) {
            const Patch patch = patch_of(mesh, i);
            const int at = static_cast<int>(out.vertices_world.size());
            for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
                out.vertices_world.push_back(
                    patch.point(u + (2 * u - 1) * share, v + (2 * v - 1) * share));
            out.quads.push_back({at, at + 1, at + 2, at + 3});
        }
        mesh = out;
    }
    return primitives;
}

using Vec2d = Eigen::Vector2d;

struct Patches : RendererTest {
    Camera camera{.eye_world = {0.3, 0.4, 6}, .target_world = Vec3d::Zero()};
    Random random{7};

    PatchMesh some() {
        return one_patch(random.in_cube(1), random.in_cube(1), random.in_cube(1),
                         random.in_cube(1));
    }
    struct Seen {
        int seen = 0;
        int beside = 0; // within roundings of an edge
    };
    /// Expects no pixel to miss a patch. One that shows another place than the ray meets must do so
    /// with patches longer or shorter by 1e-5 of their size, too: rays within roundings of an edge
    /// meet it, and the edge may lie before another part of the patch.
    ///
    /// error  of positions, by their distance from the eye: 1e-6 are a few roundings
    Seen expect_exact(Primitives primitives, double error = 1e-6, int width = 320,
                      int height = 240) {
        number_by_colour(primitives);
        renderer.load({.primitives = std::make_shared<Primitives>(primitives)});
        renderer.draw(camera, width, height, {FrameImage::Hit, FrameImage::SplatColour});
        const Image hits = renderer.read(FrameImage::Hit);
        const Image colours = renderer.read(FrameImage::SplatColour);
        const auto met = cast_primitives(primitives, camera, width, height);
        std::array<std::vector<SeenPrimitive>, 2> others; // cast where they are needed
        Seen out;
        for (std::size_t i = 0; i < met.size(); ++i) {
            const int number = number_of_colour(&colours.rgba[4 * i]);
            const auto is_shown = [&](const SeenPrimitive& seen) {
                if (number != seen.number) return false;
                if (number < 0) return true;
                const auto w = static_cast<std::size_t>(width);
                const Ray ray =
                    camera_ray(camera, width, height, double(i % w) + 0.5, double(i / w) + 0.5);
                const Vec3d p = ray.origin_world - camera.eye_world + ray.direction_world * seen.t;
                const Vec3d drawn =
                    Eigen::Map<const Eigen::Vector3f>(&hits.rgba[4 * i]).cast<double>();
                return std::abs(seen.normal.dot(drawn - p)) < error * p.norm();
            };
            out.seen += number >= 0;
            if (is_shown(met[i])) continue;
            EXPECT_FALSE(met[i].number >= 0 && number < 0) << "missed at " << i;
            ++out.beside;
            if (others[0].empty())
                others = {cast_primitives(grown(primitives, 1e-5), camera, width, height),
                          cast_primitives(grown(primitives, -1e-5), camera, width, height)};
            EXPECT_TRUE(is_shown(others[0][i]) || is_shown(others[1][i]))
                << i << ": " << number << " for " << met[i].number;
        }
        EXPECT_LE(out.beside, 3);
        return out;
    }
    int holes_in(const PatchMesh& mesh, double inner_radius, int size) {
        return holes_before_ball(renderer, {.patches = {mesh}}, inner_radius, camera, size);
    }
};

TEST_F(Patches, AreWhatTheRaysMeet) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (int run = 0; run < 4; ++run) {
            Primitives many;
            for (int i = 0; i < 20; ++i) many.patches.push_back(some());
            EXPECT_GT(expect_exact(many).seen, 5000);
        }
    }
}

// The double caster's own oracle: the patch as many triangles.
TEST_F(Patches, AreMetWhereTheirTrianglesAre) {
    for (int run = 0; run < 8; ++run) {
        const Patch patch = patch_of(some(), 0);
        constexpr int n = 64;
        TriangleMesh fine;
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i)
                fine.vertices_world.push_back(patch.point(double(i) / n, double(j) / n));
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const int at = i + (n + 1) * j;
                fine.triangles.push_back({at, at + 1, at + n + 2});
                fine.triangles.push_back({at, at + n + 2, at + n + 1});
            }
        PatchMesh mesh{.vertices_world = {patch.corners_world.begin(), patch.corners_world.end()},
                       .quads = {{0, 1, 2, 3}}};
        const auto of_patch = cast_primitives({.patches = {mesh}}, camera, 120, 90);
        const auto of_triangles = cast_primitives({.meshes = {fine}}, camera, 120, 90);
        int differ = 0;
        for (std::size_t i = 0; i < of_patch.size(); ++i) {
            differ += (of_patch[i].number >= 0) != (of_triangles[i].number >= 0);
            // A fold may show one sheet or the other: within its pixel.
            if (of_patch[i].number >= 0 && of_triangles[i].number >= 0)
                differ += std::abs(of_patch[i].t - of_triangles[i].t) > 0.01;
        }
        EXPECT_LE(differ, 8); // along folds, whose chords lie 1/8 (2/64)^2 of the size inside
    }
}

TEST_F(Patches, FromTwistedToFlatAreWhatTheRaysMeet) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (const double twist : {1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-12, 0.0})
            for (int run = 0; run < 2; ++run) {
                SCOPED_TRACE(twist);
                const Vec3d a = 1.5 * random.unit();
                const Vec3d b = a.cross(random.unit()).normalized() + 0.3 * a;
                Primitives one{
                    .patches = {one_patch(-a - b, a - b, a + b + twist * random.unit(), b - a)}};
                expect_exact(one);
                // A trapezoid, whose rulings meet in a point.
                one.patches = {
                    one_patch(-a - b, a - b, 0.4 * a + b + twist * random.unit(), b - 0.3 * a)};
                expect_exact(one);
            }
    }
}

TEST_F(Patches, WithCornersInOnePlaceAreTriangles) {
    for (int run = 0; run < 8; ++run) {
        const Vec3d a = random.in_cube(1.5), b = random.in_cube(1.5), c = random.in_cube(1.5);
        const std::array corners{a, b, c};
        for (int twice = 0; twice < 4; ++twice) {
            std::array<Vec3d, 4> quad;
            for (int k = 0, next = 0; k < 4; ++k) {
                quad[std::size_t(k)] = corners[std::size_t(next)];
                if (k != twice) next = (next + 1) % 3;
            }
            const PatchMesh patch = one_patch(quad[0], quad[1], quad[2], quad[3]);
            // u is known by less near a corner that is two.
            expect_exact({.patches = {patch}}, 3e-6);
            const auto of_patch = cast_primitives({.patches = {patch}}, camera, 160, 120);
            const auto of_triangle = cast_primitives(
                {.meshes = {{.vertices_world = {a, b, c}, .triangles = {{0, 1, 2}}}}}, camera, 160,
                120);
            for (std::size_t i = 0; i < of_patch.size(); ++i)
                EXPECT_EQ(of_patch[i].number, of_triangle[i].number);
        }
        // Opposite corners: it is folded along a line.
        expect_exact({.patches = {one_patch(a, b, a, c)}});
    }
}

TEST_F(Patches, WithoutAreaAreSkipped) {
    const Vec3d a(-1, -0.5, 0), b(1, 0.5, 0);
    EXPECT_EQ(expect_exact({.patches = {one_patch(a, b, b, a), one_patch(a, a, a, b),
                                        one_patch(a, b, a, b), one_patch(a, a, a, a)}})
                  .seen,
              0);
}

// 1e-6 high and 2 long. From near by such a sliver fills the picture's height; from afar it lies
// between the middles of pixels, or does not.
TEST_F(Patches, ThatAreSliversAreExact) {
    constexpr double height = 1e-6;
    for (int run = 0; run < 10; ++run) {
        const Vec3d along = random.unit();
        const Vec3d up = along.cross(random.unit()).normalized();
        const Vec3d twist = height * random.unit();
        const PatchMesh sliver =
            one_patch(-along, along, along + height * up + twist, -along + height * up);
        camera.eye_world = {0.3, 0.4, 6};
        camera.target_world = Vec3d::Zero();
        expect_exact({.patches = {sliver}});
        const Vec3d at = random.uniform(-0.9, 0.9) * along + 0.5 * height * up;
        camera.target_world = at;
        camera.eye_world = at + 2 * height * along.cross(up) + 0.3 * height * along;
        EXPECT_GT(expect_exact({.patches = {sliver}}, 1e-5).seen, 10000);
    }
}

TEST_F(Patches, SmallByTheirDistanceAreAsExactAsNear) {
    for (const double distance : {1e1, 1e2, 1e3, 1e4, 1e5, 1e6}) {
        SCOPED_TRACE(distance);
        camera.eye_world = distance * Vec3d(0.3, 0.5, 1).normalized();
        camera.fov_y_degrees = 2 * std::atan(1.2 / distance) * 180 / std::numbers::pi;
        for (int run = 0; run < 5; ++run) {
            // Of two sheets that are nearer to each other than depths round either may show: one
            // alone, seen from the side that it faces.
            const Vec3d to_eye = camera.eye_world.normalized();
            const Vec3d right = to_eye.cross(random.unit()).normalized();
            const Vec3d up = to_eye.cross(right);
            const auto lifted = [&](double x, double y) -> Vec3d {
                return x * right + y * up + 0.5 * random.uniform(-1, 1) * to_eye;
            };
            const PatchMesh one = one_patch(lifted(-0.8, -0.8), lifted(0.8, -0.7), lifted(0.7, 0.8),
                                            lifted(-0.6, 0.7));
            EXPECT_GT(expect_exact({.patches = {one}}, 1e-6, 121, 121).seen, 3000);
        }
    }
}

TEST_F(Patches, FarFromTheWorldsOrigin) {
    for (const double size : {1e6, 1e9}) {
        const Vec3d far = size * Vec3d(1, -2, 3);
        camera = {.eye_world = far + Vec3d(0.3, 0.4, 6), .target_world = far};
        Primitives many;
        for (int i = 0; i < 20; ++i) {
            many.patches.push_back(some());
            for (Vec3d& vertex : many.patches.back().vertices_world) vertex += far;
        }
        EXPECT_GT(expect_exact(many).seen, 5000);
    }
}

TEST_F(Patches, AcrossTheEyesPlaneAndAroundTheEye) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (int run = 0; run < 20; ++run) {
            Primitives some_around;
            for (int i = 0; i < 3; ++i)
                some_around.patches.push_back(one_patch(
                    camera.eye_world + random.in_cube(4), camera.eye_world + random.in_cube(4),
                    camera.eye_world + random.in_cube(4), camera.eye_world + random.in_cube(4)));
            // Right before the eye, of patches 1e3 times as large.
            expect_exact(some_around, 1e-4, 160, 120);
        }
    }
}

// 1,000 pairs with a common edge that passes through the middles of a row or column of pixels: what
// rays meet of patches longer by 1e-9 shows no hole, nor does the edge.
TEST_F(Patches, ThatShareAnEdgeLeaveNoCrack) {
    constexpr int size = 48;
    int holes = 0;
    int met = 0;
    for (int run = 0; run < 1000; ++run) {
        camera.eye_world = 6 * random.unit();
        camera.projection = run % 2 == 0 ? Projection::Perspective : Projection::Orthographic;
        camera.height_world = 3;
        const auto in_pixel = [&](double along, double across) -> Vec3d {
            const Vec2d at = run % 4 < 2 ? Vec2d(along, across) : Vec2d(across, along);
            const Ray ray = camera_ray(camera, size, size, at.x(), at.y());
            const double middle =
                -ray.direction_world.dot(ray.origin_world) / ray.direction_world.squaredNorm();
            return ray.origin_world + random.uniform(0.8, 1.2) * middle * ray.direction_world;
        };
        const double row = std::floor(random.uniform(12, 36)) + 0.5;
        const Vec3d p = in_pixel(random.uniform(5, 20), row);
        const Vec3d q = in_pixel(random.uniform(25, 43), row);
        const PatchMesh pair{.vertices_world = {p, q, random.in_cube(1), random.in_cube(1),
                                                random.in_cube(1), random.in_cube(1)},
                             .quads = {{0, 1, 2, 3}, {1, 0, 4, 5}}};
        const Primitives scene{.patches = {pair}};
        const Holes seen = test::holes_in(renderer, scene, grown(scene, 1e-9), camera, size);
        met += seen.met;
        holes += seen.holes;
    }
    EXPECT_GT(met, 100000);
    EXPECT_EQ(holes, 0);
}

TEST_F(Patches, OfAClosedMeshLeaveNoHole) {
    const PatchMesh sphere = quad_sphere(24, 0.2, random);
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera = {.target_world = Vec3d::Zero(), .projection = projection, .height_world = 2.2};
        for (int run = 0; run < 10; ++run) {
            camera.eye_world = 5 * random.unit();
            EXPECT_EQ(holes_in(sphere, 0.95, 300), 0);
        }
        // Edges along rows and columns of pixels, and vertices in their middles.
        for (const Vec3d& direction : {Vec3d(0, 0, 1), Vec3d(0, 0, -1), Vec3d(1, 0, 0)})
            for (const int size : {100, 101}) {
                camera.eye_world = 5 * direction;
                EXPECT_EQ(holes_in(quad_sphere(2, 0, random), 0.5, size), 0);
                EXPECT_EQ(holes_in(quad_sphere(16, 0, random), 0.95, size), 0);
            }
    }
}

TEST_F(Patches, HaveTheNormalsAndCurvaturesOfTheirSurface) {
    // z = a xy over [-1, 1]^2.
    constexpr double a = 0.7;
    const PatchMesh saddle = one_patch({-1, -1, a}, {1, -1, -a}, {1, 1, a}, {-1, 1, -a});
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera = {.eye_world = {1, -2, 5},
                  .target_world = Vec3d::Zero(),
                  .projection = projection,
                  .height_world = 3};
        renderer.load(
            {.primitives = std::make_shared<Primitives>(Primitives{.patches = {saddle}})});
        renderer.draw(camera, 100, 100,
                      {FrameImage::Hit, FrameImage::Gradient, FrameImage::Curvature});
        const Image hits = renderer.read(FrameImage::Hit);
        const Image normals = renderer.read(FrameImage::Gradient);
        const Image curvatures = renderer.read(FrameImage::Curvature);
        int seen = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            if (hits.rgba[i + 3] == 0) continue;
            ++seen;
            const Vec3d p = point_at(hits, i, camera);
            EXPECT_NEAR(p.z(), a * p.x() * p.y(), 1e-5);
            const double w = std::sqrt(1 + a * a * (p.x() * p.x() + p.y() * p.y()));
            const Vec3d normal = Vec3d(-a * p.y(), -a * p.x(), 1) / w;
            EXPECT_LT((Eigen::Map<const Eigen::Vector3f>(&normals.rgba[i]).cast<double>() - normal)
                          .norm(),
                      1e-5);
            // Of a height function: K = -a^2 / w^4, H = a^3 xy / w^3, of the sign by which balls
            // bend outwards.
            const double k = -a * a / std::pow(w, 4);
            const double h = a * a * a * p.x() * p.y() / std::pow(w, 3);
            const double root = std::sqrt(h * h - k);
            EXPECT_NEAR(curvatures.rgba[i], h + root, 1e-5);
            EXPECT_NEAR(curvatures.rgba[i + 1], h - root, 1e-5);
        }
        EXPECT_GT(seen, 2000);
    }
}

TEST_F(Patches, CastShadowsAlongTheLightsRays) {
    const PatchMesh floor = one_patch({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2});
    const PatchMesh above =
        one_patch({-0.6, 0.9, 0.5}, {0.7, 0.6, 0.6}, {0.6, 1, -0.6}, {-0.5, 0.5, -0.7});
    const Vec3d light = Vec3d(0.4, 1, 0.3).normalized();
    camera.eye_world = {1, 4, 5};
    const auto is_met = [&](const Vec3d& p) {
        return intersect(patch_of(above, 0), p, light).has_value();
    };
    constexpr int size = 200;
    constexpr double texel = 6.0 / size; // less than the light's view of the floor by 200
    const auto is_lit = [&](const Vec3d& p) -> std::optional<bool> {
        for (const double x : {-2 * texel, 0.0, 2 * texel})
            for (const double z : {-2 * texel, 0.0, 2 * texel})
                if (is_met(p + Vec3d(x, 0, z)) != is_met(p)) return std::nullopt;
        return !is_met(p);
    };
    const auto [dark, lit] =
        judge_hard_shadows(renderer, {.patches = {floor, above}}, light, camera, size, 0, is_lit);
    EXPECT_GT(dark, 500);
    EXPECT_GT(lit, 5000);
}

// Rays to the sky, from among the patches: a floor below a patch as large sees less of it.
TEST_F(Patches, HideTheSkyFromWhatIsBelow) {
    const PatchMesh floor = one_patch({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2});
    const PatchMesh above = one_patch({-2, 0.3, 2}, {0, 0.3, 2}, {0, 0.3, -2}, {-2, 0.3, -2});
    camera.eye_world = {0.5, 0.15, 6};
    camera.target_world = {0, 0.1, 0};
    Look look;
    look.effects.occlusion.strength = 1;
    look.effects.occlusion.distance_world = 1;
    renderer.load(
        {.look = look,
         .primitives = std::make_shared<Primitives>(Primitives{.patches = {floor, above}})});
    renderer.draw(camera, 160, 120, {FrameImage::Occlusion, FrameImage::Hit});
    const Image open = renderer.read(FrameImage::Occlusion);
    const Image hits = renderer.read(FrameImage::Hit);
    int covered = 0;
    int free = 0;
    for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
        if (hits.rgba[i + 3] == 0) continue;
        const Vec3d p = point_at(hits, i, camera);
        if (std::abs(p.y()) > 1e-3 || std::abs(p.z()) > 0.9) continue;
        if (p.x() < -0.9 && p.x() > -1.1) { // the way up is barred within 0.9
            EXPECT_LT(open.rgba[i], 0.3) << p.transpose();
            ++covered;
        }
        if (p.x() > 1.05) {
            EXPECT_EQ(open.rgba[i], 1) << p.transpose();
            ++free;
        }
    }
    EXPECT_GT(covered, 10);
    EXPECT_GT(free, 10);
}

// Their code is no part of other kinds' programs: these compile where it is an error.
TEST_F(Patches, AreNoPartOfOtherKindsPrograms) {
    for (const auto* file : {"patch", "tetrahedron"}) {
        const TemporaryFolder folder;
        std::filesystem::copy(shader_folder, folder / "shaders",
                              std::filesystem::copy_options::recursive);
        std::ofstream(folder / "shaders/quadrics" / (std::string(file) + ".glsl")) << "#error\n";
        Renderer poisoned(*context, folder / "shaders");
        Primitives others{.spheres = {random.sphere()}, .quadrics = {random.clipped_quadric()}};
        others.meshes.push_back(
            {.vertices_world = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}});
        Look look;
        look.effects.occlusion.strength = 1;
        const ImageSet images{FrameImage::Beauty, FrameImage::Curvature};
        poisoned.load({.look = look, .primitives = std::make_shared<Primitives>(others)});
        EXPECT_NO_THROW(poisoned.draw(camera, 40, 40, images));
        if (file == std::string("patch"))
            others.patches.push_back(some());
        else
            others.tetrahedra.push_back(
                {.vertices_world = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                 .tetrahedra = {{0, 1, 2, 3}},
                 .coefficients = {{-1, 1, 1, 1, 0, 0, 0, 0, 0, 0}}});
        poisoned.load({.look = look, .primitives = std::make_shared<Primitives>(others)});
        EXPECT_THROW(poisoned.draw(camera, 40, 40, images), gl::GlError);
    }
}

TEST_F(Patches, ThatCannotBeDrawnAreRefusedByTheirIndex) {
    PatchMesh mesh = some();
    mesh.vertices_world[2].y() = NAN;
    const auto load = [&] {
        renderer.load(
            {.primitives = std::make_shared<Primitives>(Primitives{.patches = {some(), mesh}})});
    };
    EXPECT_THAT(load, testing::ThrowsMessage<InputError>(
                          testing::HasSubstr("patches 1: vertex 2 is not finite")));
    mesh = some();
    mesh.quads[0][1] = 4;
    EXPECT_THAT(load, testing::ThrowsMessage<InputError>(
                          testing::HasSubstr("patches 1: quad 0: there is no vertex 4")));
}

} // namespace
} // namespace isocast::test
