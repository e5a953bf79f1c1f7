// SPDX-License-Identifier: MPL-2.0
#include "apps/view/navigation.h"

#include <algorithm>

namespace isocast::view {

namespace {

Camera turned(Camera camera, const Vec3d& pivot_world, const Mat3d& rotation) {
    camera.eye_world = pivot_world + rotation * (camera.eye_world - pivot_world);
    camera.target_world = pivot_world + rotation * (camera.target_world - pivot_world);
    camera.up = rotation * camera.up;
    return camera;
}

/// Of the pivot; where it lies behind the eye, that of the target.
double depth_of(const Camera& camera, const Vec3d& pivot_world) {
    const Vec3d forward = (camera.target_world - camera.eye_world).normalized();
    const double depth = forward.dot(pivot_world - camera.eye_world);
    return depth > 0 ? depth : (camera.target_world - camera.eye_world).norm();
}

} // namespace

Camera rotated(const Camera& camera, const Vec3d& pivot_world, double about_up,
               double about_right) {
    const Mat3d view = camera.view_from_world_rotation();
    Camera upright = camera;
    upright.up = view.row(1).transpose();
    return turned(upright, pivot_world,
                  (Eigen::AngleAxisd(about_up, view.row(1).transpose()) *
                   Eigen::AngleAxisd(about_right, view.row(0).transpose()))
                      .toRotationMatrix());
}

Camera rolled(const Camera& camera, double angle) {
    Camera out = camera;
    const Mat3d view = camera.view_from_world_rotation();
    // What is seen turns against the camera.
    out.up = Eigen::AngleAxisd(-angle, view.row(2).transpose()) * view.row(1).transpose();
    return out;
}

Camera panned(const Camera& camera, const Vec3d& pivot_world, int height, double dx, double dy) {
    const Mat3d view = camera.view_from_world_rotation();
    const double pixel_world =
        2 * camera.half_height_at(depth_of(camera, pivot_world)) / std::max(height, 1);
    const Vec3d shift = pixel_world * (dy * view.row(1) - dx * view.row(0)).transpose();
    Camera out = camera;
    out.eye_world += shift;
    out.target_world += shift;
    return out;
}

Camera zoomed(const Camera& camera, const Vec3d& pivot_world, int width, int height, double x,
              double y, double factor) {
    Camera out = camera;
    const Ray ray = camera_ray(camera, width, height, x, y);
    const Vec3d forward = (camera.target_world - camera.eye_world).normalized();
    if (camera.projection == Projection::Orthographic) {
        // The point under the cursor keeps its share of a picture that is smaller.
        const Vec3d aside = ray.origin_world - camera.eye_world;
        const Vec3d shift = (1 - factor) * (aside - forward * forward.dot(aside));
        out.height_world *= factor;
        out.eye_world += shift;
        out.target_world += shift;
        return out;
    }
    const double depth = depth_of(camera, pivot_world);
    const Vec3d at =
        camera.eye_world + depth / forward.dot(ray.direction_world) * ray.direction_world;
    const Vec3d step = (1 - factor) * (at - camera.eye_world);
    out.eye_world += step;
    // As far ahead as the pivot is, so that zooming never passes the target.
    out.target_world = out.eye_world + factor * depth * forward;
    return out;
}

Camera seen_from(const Camera& camera, const Vec3d& pivot_world, const Vec3d& direction_to_eye,
                 const Vec3d& up) {
    Camera out = camera;
    out.target_world = pivot_world;
    out.eye_world = pivot_world + depth_of(camera, pivot_world) * direction_to_eye;
    out.up = up;
    return out;
}

Camera with_other_projection(const Camera& camera, const Vec3d& pivot_world) {
    Camera out = camera;
    const double depth = depth_of(camera, pivot_world);
    if (camera.projection == Projection::Perspective) {
        out.projection = Projection::Orthographic;
        out.height_world = 2 * camera.half_height_at(depth);
        return out;
    }
    out.projection = Projection::Perspective;
    // The eye goes where the picture's height is seen at the pivot's depth.
    const Vec3d forward = (camera.target_world - camera.eye_world).normalized();
    const double needed = camera.height_world / 2 / out.half_height_at(1);
    out.eye_world += (depth - needed) * forward;
    out.target_world = out.eye_world + needed * forward;
    return out;
}

} // namespace isocast::view
