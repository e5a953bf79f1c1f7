// SPDX-License-Identifier: MPL-2.0
#include "apps/camera_spec.h"

#include "apps/inputs.h"

#include <fmt/format.h>

#include <vector>

namespace isocast {

namespace {

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (;;) {
        const auto end = text.find(separator);
        parts.push_back(text.substr(0, end));
        if (end == std::string_view::npos) return parts;
        text.remove_prefix(end + 1);
    }
}

Vec3d vector_from(std::string_view text) {
    const auto parts = split(text, ',');
    if (parts.size() != 3) throw UsageError(fmt::format("'{}' is not x,y,z", text));
    return {number_from(parts[0]), number_from(parts[1]), number_from(parts[2])};
}

Vec3d direction_from(std::string_view text) {
    const Vec3d direction = vector_from(text);
    if (!(direction.norm() > 0)) throw UsageError(fmt::format("'{}' has no direction", text));
    return direction;
}

double number_between(std::string_view text, double low, double high) {
    const double value = number_from(text);
    if (!(value > low && value < high))
        throw UsageError(fmt::format("{} does not lie between {} and {}", text, low, high));
    return value;
}

void set(CameraSpec& spec, std::string_view key, std::string_view value) {
    if (key == "eye")
        spec.eye_world = vector_from(value);
    else if (key == "target")
        spec.target_world = vector_from(value);
    else if (key == "direction")
        spec.direction_to_eye = direction_from(value);
    else if (key == "up")
        spec.up = direction_from(value);
    else if (key == "fov")
        spec.fov_y_degrees = number_between(value, 0, 180);
    else if (key == "height")
        spec.height_world = number_between(value, 0, std::numeric_limits<double>::infinity());
    else
        throw UsageError(
            fmt::format("unknown key '{}' (known: eye, target, direction, up, fov, height)", key));
}

} // namespace

CameraSpec camera_spec_from(std::string_view text) {
    CameraSpec spec;
    for (const std::string_view pair : split(text, ';')) {
        const auto equals = pair.find('=');
        if (equals == std::string_view::npos)
            throw UsageError(fmt::format("'{}' is not key=value", pair));
        set(spec, pair.substr(0, equals), pair.substr(equals + 1));
    }
    if (spec.eye_world && spec.direction_to_eye)
        throw UsageError("eye and direction exclude each other");
    if (spec.target_world && !spec.eye_world) throw UsageError("target needs eye");
    if (spec.fov_y_degrees && spec.height_world)
        throw UsageError("fov (perspective) and height (orthographic) exclude each other");
    return spec;
}

Camera camera_from(const CameraSpec& spec, std::span<const Vec3d> points_world, double aspect) {
    const double fov = spec.fov_y_degrees.value_or(30);
    const Vec3d up = spec.up.value_or(Vec3d::UnitY());
    Camera camera;
    if (spec.eye_world) {
        Eigen::AlignedBox3d box;
        for (const Vec3d& point : points_world) box.extend(point);
        camera.eye_world = *spec.eye_world;
        camera.target_world = spec.target_world.value_or(box.center());
        camera.up = up;
        camera.fov_y_degrees = fov;
    } else {
        // A little from the right and from above.
        const Vec3d direction = spec.direction_to_eye.value_or(Vec3d(0.45, 0.35, 1));
        // frame_box() has y upwards: the world is turned so that `up` is y, and back.
        const Mat3d turn = Eigen::Quaterniond::FromTwoVectors(up, Vec3d::UnitY()).matrix();
        std::vector<Vec3d> turned(points_world.begin(), points_world.end());
        for (Vec3d& point : turned) point = turn * point;
        camera = frame_box(turned, turn * direction, aspect, fov);
        camera.eye_world = turn.transpose() * camera.eye_world;
        camera.target_world = turn.transpose() * camera.target_world;
        camera.up = spec.up ? up : camera.up;
    }
    if (spec.height_world) {
        camera.projection = Projection::Orthographic;
        camera.height_world = *spec.height_world;
    }
    camera.view_from_world_rotation(); // throws if there is none
    return camera;
}

} // namespace isocast
