// The camera as a user writes it: "direction=1,1,1;fov=40".
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/camera.h"

#include <optional>
#include <string_view>

namespace isocast {

/// What a user said of the camera. Positions in world space.
struct CameraSpec {
    std::optional<Vec3d> eye_world;
    std::optional<Vec3d> target_world;     // with eye_world only
    std::optional<Vec3d> direction_to_eye; // from the object; the object then fills the picture
    std::optional<Vec3d> up;
    std::optional<double> fov_y_degrees;
    std::optional<double> height_world; // orthographic
    bool is_stereo = false;
    std::optional<double> eye_separation_world; // of a stereo pair; else by the target's distance
};

/// Pairs key=value separated by ';'. Keys: eye, target, direction, up (x,y,z), fov [degrees],
/// height [world].
/// throws  UsageError for anything else, and for keys that exclude each other
CameraSpec camera_spec_from(std::string_view text);

/// The camera that the spec asks for. What it leaves open is chosen so that the convex hull of some
/// points of the object fills the picture.
///
/// aspect  width / height of the picture
/// throws  InputError if eye and target coincide or up lies along the view
Camera camera_from(const CameraSpec& spec, std::span<const Vec3d> points_world, double aspect);

} // namespace isocast
