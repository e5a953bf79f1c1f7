// SPDX-License-Identifier: MPL-2.0
#include "apps/camera_spec.h"

#include "apps/inputs.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace isocast::test {
namespace {

std::array<Vec3d, 8> box_corners(const Vec3d& min, const Vec3d& max) {
    std::array<Vec3d, 8> corners;
    for (int i = 0; i < 8; ++i)
        corners[static_cast<std::size_t>(i)] = {
            i & 1 ? max.x() : min.x(), i & 2 ? max.y() : min.y(), i & 4 ? max.z() : min.z()};
    return corners;
}

const std::array<Vec3d, 8> corners = box_corners({-1, 2, 5}, {3, 4, 11});

/// The greatest |x| or |y| of the corners in the picture, whose border is at 1.
double extent_in_picture(const Camera& camera, double aspect) {
    const double tan_y = std::tan(camera.fov_y_degrees * std::numbers::pi / 360);
    double extent = 0;
    for (const Vec3d& corner : corners) {
        const Vec3d p = camera.view_from_world_rotation() * (corner - camera.eye_world);
        EXPECT_LT(p.z(), 0); // in front of the eye
        extent = std::max({extent, std::abs(p.y() / -p.z()) / tan_y,
                           std::abs(p.x() / -p.z()) / (tan_y * aspect)});
    }
    return extent;
}

TEST(CameraSpec, ObjectFillsThePictureFromAnyDirectionAnyWayUp) {
    for (const char* text : {"fov=30", "direction=1,0,0", "direction=0,1,0",
                             "direction=-1,-2,-3;fov=70", "direction=1,0,0;up=0,1,1",
                             "direction=1,2,3;up=0,0,-4", "up=1,1,0", "direction=0,1,0;up=0,0,1"})
        for (const double aspect : {0.5, 1.0, 3.0})
            // 0.96: the margin of 4 % that frame_box promises; 1e-9: rounding of a few operations.
            EXPECT_NEAR(
                extent_in_picture(camera_from(camera_spec_from(text), corners, aspect), aspect),
                0.96, 1e-9)
                << text << " at " << aspect;
}

TEST(CameraSpec, DirectionLeadsFromTheObjectToTheEye) {
    const Camera camera = camera_from(camera_spec_from("direction=1,2,3;up=0,0,1"), corners, 1);
    const Vec3d centre(1, 3, 8);
    // 1e-12: rounding of the turn to `up` and back.
    EXPECT_NEAR((camera.eye_world - centre).normalized().dot(Vec3d(1, 2, 3).normalized()), 1,
                1e-12);
    EXPECT_EQ(camera.up, Vec3d(0, 0, 1));
}

TEST(CameraSpec, EyeTargetUpAndFovAreTaken) {
    const Camera camera =
        camera_from(camera_spec_from("eye=1,2,3;target=-1,0.5,2e1;up=1,0,0;fov=45"), corners, 1);
    EXPECT_EQ(camera.eye_world, Vec3d(1, 2, 3));
    EXPECT_EQ(camera.target_world, Vec3d(-1, 0.5, 20));
    EXPECT_EQ(camera.up, Vec3d(1, 0, 0));
    EXPECT_EQ(camera.fov_y_degrees, 45);
    EXPECT_EQ(camera.projection, Projection::Perspective);
}

TEST(CameraSpec, EyeAloneLooksAtTheObject) {
    const Camera camera = camera_from(camera_spec_from("eye=9,9,9"), corners, 1);
    EXPECT_EQ(camera.target_world, Vec3d(1, 3, 8));
}

TEST(CameraSpec, HeightMakesItOrthographic) {
    const Camera camera = camera_from(camera_spec_from("height=2.5"), corners, 1);
    EXPECT_EQ(camera.projection, Projection::Orthographic);
    EXPECT_EQ(camera.height_world, 2.5);
}

TEST(CameraSpec, RefusesWhatItDoesNotUnderstand) {
    for (const char* text :
         {"", "eye", "eye=", "eye=1,2", "eye=1,2,3,4", "eye=1,2,x", "zoom=2", "fov=0", "fov=180",
          "fov=nan", "height=0", "height=-1", "up=0,0,0", "direction=0,0,0", "fov=30;",
          "eye=1,2,3;direction=1,0,0", "target=1,2,3", "fov=30;height=2"})
        EXPECT_THROW(camera_spec_from(text), UsageError) << text;
}

TEST(CameraSpec, RefusesViewsThatHaveNoUp) {
    EXPECT_THROW(camera_from(camera_spec_from("direction=1,2,3;up=-1,-2,-3"), corners, 1),
                 InputError);
    EXPECT_THROW(camera_from(camera_spec_from("eye=1,3,8"), corners, 1), InputError);
}

} // namespace
} // namespace isocast::test
