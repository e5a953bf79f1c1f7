// Rays, framing, and the ray coefficients that the shaders get.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/camera.h"

#include "raycaster/passes.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace isocast {
namespace {

struct RandomVectors {
    std::mt19937_64 generator{7};
    Vec3d operator()() {
        std::normal_distribution<double> normal;
        return {normal(generator), normal(generator), normal(generator)};
    }
};

/// Distance of p from the line of a ray, relative to the distance from its origin.
double angle_off(const Ray& ray, const Vec3d& p) {
    const Vec3d to_p = p - ray.origin_world;
    return to_p.cross(ray.direction_world.normalized()).norm() / to_p.norm();
}

TEST(Camera, CentreRayMeetsTheTarget) {
    RandomVectors random;
    for (int i = 0; i < 100; ++i) {
        const Camera camera{.eye_world = random(), .target_world = random(), .up = random()};
        // 1e-14: a few roundings of unit vectors.
        EXPECT_LT(angle_off(camera_ray(camera, 640, 480, 320, 240), camera.target_world), 1e-14);
    }
}

TEST(Camera, FieldOfViewIsTheAngleBetweenTopAndBottomRays) {
    const Camera camera{.fov_y_degrees = 50};
    const Vec3d top = camera_ray(camera, 300, 200, 150, 0).direction_world.normalized();
    const Vec3d bottom = camera_ray(camera, 300, 200, 150, 200).direction_world.normalized();
    EXPECT_NEAR(std::acos(top.dot(bottom)) * 180 / std::numbers::pi, 50, 1e-12);
    EXPECT_GT(top.y(), bottom.y()) << "y = 0 is the top row";
}

TEST(Camera, RefusesWhatHasNoOrientation) {
    Camera camera;
    camera.target_world = camera.eye_world;
    EXPECT_THROW(camera.view_from_world_rotation(), InputError);
    camera.target_world = camera.eye_world + camera.up;
    EXPECT_THROW(camera.view_from_world_rotation(), InputError);
    EXPECT_THROW(frame_box({}, Vec3d::UnitZ(), 1, 180), InputError);
}

TEST(FrameBox, HoldsEveryCornerAndTouchesTheMargin) {
    RandomVectors random;
    for (int i = 0; i < 200; ++i) {
        std::array<Vec3d, 8> corners;
        const Vec3d size = random().cwiseAbs();
        const Vec3d origin = 10 * random();
        for (int c = 0; c < 8; ++c)
            corners[std::size_t(c)] =
                origin + Vec3d(c & 1 ? size.x() : 0, c & 2 ? size.y() : 0, c & 4 ? size.z() : 0);
        const double aspect = 0.5 + i / 100.0;
        const Vec3d direction = i == 0 ? Vec3d::UnitY().eval() : random();
        const Camera camera = frame_box(corners, direction, aspect, 30);
        const Mat3d rotation = camera.view_from_world_rotation();
        const double tan_y = std::tan(15 * std::numbers::pi / 180);
        double greatest = 0;
        for (const Vec3d& corner : corners) {
            const Vec3d p = rotation * (corner - camera.eye_world);
            ASSERT_LT(p.z(), 0);
            greatest = std::max({greatest, std::abs(p.y() / p.z()) / tan_y,
                                 std::abs(p.x() / p.z()) / (tan_y * aspect)});
        }
        EXPECT_NEAR(greatest, 0.96, 1e-9); // the margin that frame_box documents
    }
}

TEST(RayCoefficients, DescribeTheSameLinesAsCameraRays) {
    RandomVectors random;
    for (int i = 0; i < 100; ++i) {
        Camera camera{.eye_world = 5 * random(), .target_world = random(), .up = random()};
        if (i % 2) camera.projection = Projection::Orthographic;
        GridSpace space;
        space.world_from_index.linear() << random(), random(), random(); // sheared, maybe mirrored
        space.world_from_index.translation() = random();
        const Index3 origin(32, -64, 96 * (i % 3));
        const int width = 64;
        const int height = 48;
        const RayCoefficients ray = ray_coefficients(camera, width, height, space, origin);
        for (const auto& [x, y] : {std::pair{0.5, 0.5}, {10.5, 40.5}, {63.5, 20.5}}) {
            // gl_FragCoord has its origin at the bottom.
            const Vec3d pixel(1, x, height - y);
            const Ray expected = camera_ray(camera, width, height, x, y);
            const Vec3d point = space.to_world(ray.point * pixel + origin.cast<double>());
            const Vec3d start =
                space.to_world((ray.point - ray.vector) * pixel + origin.cast<double>());
            // 1e-9: rounding, amplified by the condition of a random linear map (below 1e5 here).
            EXPECT_LT((start - expected.origin_world).norm(), 1e-9);
            EXPECT_LT(angle_off(expected, point), 1e-9);
            EXPECT_GT((point - start).dot(expected.direction_world), 0);
            EXPECT_LT((space.world_from_index.linear() * (ray.from_eye * pixel) -
                       (point - camera.eye_world))
                          .norm(),
                      1e-9);
        }
    }
}

} // namespace
} // namespace isocast
