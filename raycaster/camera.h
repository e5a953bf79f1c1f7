// The camera: where rays start and where they go.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <span>

namespace isocast {

enum class Projection { Perspective, Orthographic };

/// A pinhole or parallel camera. Pixel (0, 0) is at the top left of the image; rays pass through
/// pixel centres.
struct Camera {
    Vec3d eye_world = Vec3d(0, 0, 1);
    Vec3d target_world = Vec3d::Zero();
    Vec3d up = Vec3d::UnitY(); // any length, not along the view
    Projection projection = Projection::Perspective;
    double fov_y_degrees = 30; // perspective: full vertical angle
    double height_world = 2;   // orthographic: height of the picture

    /// Rows: right, up, back (towards the viewer); orthonormal.
    /// throws  InputError if eye and target coincide or up lies along the view
    Mat3d view_from_world_rotation() const;
    /// Half the height of the picture `depth` in front of the eye [world].
    double half_height_at(double depth) const;

    bool operator==(const Camera&) const = default;
};

/// No side of a picture is longer: beyond it float positions of rays lose 1/128 of a pixel.
inline constexpr int max_picture_extent = 1 << 17;

/// The part of a picture that is drawn at a time, and where in their pixels its rays pass.
struct PicturePart {
    int x = 0; // of its top left pixel
    int y = 0;
    int width = 0;
    int height = 0;
    /// From pixel centres, to the right and down [pixels]; floats hold multiples of 1/128.
    Eigen::Vector2d shift = Eigen::Vector2d::Zero();

    /// Of a picture of that height, the place of the part's bottom left corner from the picture's,
    /// and the shift, in gl_FragCoord's axes.
    Eigen::Vector2d first_pixel(int picture_height) const {
        return {x + shift.x(), picture_height - y - height - shift.y()};
    }

    bool operator==(const PicturePart&) const = default;
};

/// A ray in world space, not normalised: for a perspective camera it starts at the eye, for an
/// orthographic one on the plane through the eye.
struct Ray {
    Vec3d origin_world;
    Vec3d direction_world;
};

/// The ray through the point (x, y) of a width x height image, in pixels from the top left corner;
/// pixel (i, j) has its centre at (i + 0.5, j + 0.5).
Ray camera_ray(const Camera& camera, int width, int height, double x, double y);

/// A perspective camera that sees the convex hull of some points, like the corners of a box, from
/// `direction_to_eye`, with a margin of 4 % of the picture.
/// throws  InputError unless 0 < fov < 180
Camera frame_box(std::span<const Vec3d> points_world, const Vec3d& direction_to_eye, double aspect,
                 double fov_y_degrees);

} // namespace isocast
