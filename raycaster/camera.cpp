// SPDX-License-Identifier: MPL-2.0
#include "raycaster/camera.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isocast {

Mat3d Camera::view_from_world_rotation() const {
    const Vec3d back = eye_world - target_world;
    if (!(back.norm() > 0) || !back.allFinite())
        throw InputError("camera: eye and target must be two different points");
    const Vec3d z = back.normalized();
    const Vec3d x = up.normalized().cross(z);
    // 1e-6 rad: nearer to the view direction, "up" no longer says which way is up.
    if (!(x.norm() > 1e-6)) throw InputError("camera: up must not lie along the view direction");
    Mat3d rotation;
    rotation.row(0) = x.normalized();
    rotation.row(1) = z.cross(x.normalized());
    rotation.row(2) = z;
    return rotation;
}

double Camera::half_height_at(double depth) const {
    return projection == Projection::Perspective
               ? depth * std::tan(fov_y_degrees * std::numbers::pi / 360)
               : height_world / 2;
}

Ray camera_ray(const Camera& camera, int width, int height, double x, double y) {
    const Mat3d world_from_view = camera.view_from_world_rotation().transpose();
    const double aspect = double(width) / height;
    const double ndc_x = 2 * x / width - 1;
    const double ndc_y = 1 - 2 * y / height;
    const double half_height = camera.half_height_at(1);
    if (camera.projection == Projection::Perspective) {
        return {camera.eye_world,
                world_from_view * Vec3d(ndc_x * half_height * aspect, ndc_y * half_height, -1)};
    }
    return {camera.eye_world +
                world_from_view * Vec3d(ndc_x * half_height * aspect, ndc_y * half_height, 0),
            world_from_view * Vec3d(0, 0, -1)};
}

Camera frame_box(std::span<const Vec3d> points_world, const Vec3d& direction_to_eye, double aspect,
                 double fov_y_degrees) {
    if (!(fov_y_degrees > 0 && fov_y_degrees < 180))
        throw InputError(
            fmt::format("camera: fov must lie between 0 and 180 degrees, not {}", fov_y_degrees));
    Eigen::AlignedBox3d box;
    for (const Vec3d& point : points_world) box.extend(point);
    const Vec3d centre = box.isEmpty() ? Vec3d(Vec3d::Zero()) : Vec3d(box.center());

    Camera camera;
    camera.fov_y_degrees = fov_y_degrees;
    camera.target_world = centre;
    camera.eye_world = centre + direction_to_eye.normalized();
    // Seen from straight above or below, "up" is the far side of the object.
    if (direction_to_eye.normalized().cross(camera.up).norm() < 1e-3) camera.up = -Vec3d::UnitZ();
    const Mat3d rotation = camera.view_from_world_rotation();

    // 0.96: a margin of 4 %. A point (x, y, z) relative to the centre is inside the picture if
    // |y| <= tan * (distance - z), likewise for x with the aspect.
    const double tan_y = 0.96 * std::tan(fov_y_degrees * std::numbers::pi / 360);
    double distance = 0;
    for (const Vec3d& point : points_world) {
        const Vec3d p = rotation * (point - centre);
        distance = std::max({distance, p.z() + std::abs(p.y()) / tan_y,
                             p.z() + std::abs(p.x()) / (tan_y * aspect)});
    }
    camera.eye_world = centre + direction_to_eye.normalized() * distance;
    return camera;
}

} // namespace isocast
