// Skin surfaces against spheres, the hyperboloid between two, and the balls that they hold.
// SPDX-License-Identifier: MPL-2.0
#include "../quadrics/random_primitives.h"
#include "../splats/splat_judge.h"
#include "quadrics/skin/skin_surface.h"
#include "renderer_test_base.h"
#include "volume/errors.h"

namespace isocast::test {
namespace {

/// The first of all hits; infinitely far if there is none.
TetrahedronHit first_hit(const TetrahedralMesh& mesh, const Vec3d& origin, const Vec3d& way) {
    TetrahedronHit first{std::numeric_limits<double>::infinity(), Vec3d::Zero()};
    for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
        const auto hit = intersect(tetrahedron_of(mesh, i), origin, way);
        if (hit && hit->t < first.t) first = *hit;
    }
    return first;
}

// 1e-6: floats of values up to that of two radii, by the slope on the surface.
constexpr double roundings = 1e-6;

TEST(Skin, OfOneBallIsItsSphere) {
    Random random(1);
    for (const double shrink : {0.2, 0.5, 0.8})
        for (const double radius : {1e-3, 1.5, 200.0}) {
            const Vec3d centre = radius * random.in_cube(5);
            const TetrahedralMesh skin = skin_surface(
                std::vector<Sphere>{{.centre_world = centre, .radius_world = radius}}, shrink);
            EXPECT_TRUE(skin.is_closed);
            for (int i = 0; i < 50; ++i) {
                const Vec3d d = random.unit();
                const TetrahedronHit hit = first_hit(skin, centre + 4 * radius * d, -d);
                EXPECT_NEAR(hit.t, 3 * radius, roundings * radius);
                EXPECT_LT((hit.normal - d).norm(), 1e-5); // of differences of the same values
            }
        }
}

// Edelsbrunner 1999: between two equal balls, where |x| <= (1 - s) d / 2 from the middle, the
// surface is rho^2 = r^2 - s d^2 / 4 + s / (1 - s) x^2.
TEST(Skin, OfTwoBallsHasTheHyperboloidBetween) {
    Random random(2);
    const double r = 1.3, d = 1.9;
    for (const double s : {0.3, 0.5, 0.7}) {
        const TetrahedralMesh skin =
            skin_surface(std::vector<Sphere>{{.centre_world = {-d / 2, 0, 0}, .radius_world = r},
                                             {.centre_world = {d / 2, 0, 0}, .radius_world = r}},
                         s);
        for (int i = 0; i < 50; ++i) {
            const double x = random.uniform(-1, 1) * (1 - s) * d / 2;
            const double angle = random.uniform(0, 6);
            const Vec3d out(0, std::cos(angle), std::sin(angle));
            const TetrahedronHit hit = first_hit(skin, Vec3d(x, 0, 0) + 5 * out, -out);
            EXPECT_NEAR(5 - hit.t, std::sqrt(r * r - s * d * d / 4 + s / (1 - s) * x * x),
                        roundings);
        }
    }
}

std::vector<Sphere> some_balls(Random& random, int count) {
    std::vector<Sphere> balls;
    for (int i = 0; i < count; ++i)
        balls.push_back(
            {.centre_world = random.in_cube(2), .radius_world = random.uniform(0.5, 0.9)});
    return balls;
}

TEST(Skin, HoldsItsBallsAndIsMetFromOutside) {
    Random random(3);
    const std::vector<Sphere> balls = some_balls(random, 12);
    const TetrahedralMesh skin = skin_surface(balls);
    for (const Sphere& ball : balls)
        for (int i = 0; i < 20; ++i) {
            const Vec3d d = random.unit();
            const TetrahedronHit hit = first_hit(skin, ball.centre_world + 9 * d, -d);
            EXPECT_LE(hit.t, 9 - ball.radius_world + roundings);
            EXPECT_GT(hit.normal.dot(d), 0);
        }
}

// CGAL's complex reaches far beyond; pictures are framed by vertices.
TEST(Skin, EndsNearItsBalls) {
    Random random(5);
    const TetrahedralMesh skin = skin_surface(some_balls(random, 12));
    for (const Vec3d& vertex : skin.vertices_world) // 2 + 0.9, and an edge of 1.8
        EXPECT_LT(vertex.cwiseAbs().maxCoeff(), 2.9 + 1.8);
}

TEST(Skin, IsRefusedWithoutBallsOrAShareOfThem) {
    EXPECT_THROW(skin_surface({}), InputError);
    for (const double shrink : {0.0, 1.0, -1.0, std::nan("")})
        EXPECT_THROW(skin_surface(std::vector<Sphere>{{}}, shrink), InputError);
}

struct DrawnSkin : RendererTest {};

// Cut tetrahedra have common faces: no ray passes between them.
TEST_F(DrawnSkin, HasNoHoles) {
    Random random(4);
    for (int run = 0; run < 4; ++run) {
        const std::vector<Sphere> balls = some_balls(random, 12);
        std::vector<Sphere> inner = balls;
        for (Sphere& ball : inner) ball.radius_world *= 1 - 1e-5;
        for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
            const Camera camera{.eye_world = 9 * random.unit(),
                                .target_world = Vec3d::Zero(),
                                .projection = projection,
                                .height_world = 6};
            const Holes seen = holes_in(renderer, {.tetrahedra = {skin_surface(balls)}},
                                        {.spheres = inner}, camera, 200);
            EXPECT_GT(seen.met, 5000);
            EXPECT_EQ(seen.holes, 0);
        }
    }
}

} // namespace
} // namespace isocast::test
