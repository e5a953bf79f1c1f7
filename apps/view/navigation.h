// How a camera moves by the mouse: pure, in double.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/camera.h"

namespace isocast::view {

/// About the pivot, by angles about the picture's up and right axes [radians]: what is in front
/// follows the mouse.
Camera rotated(const Camera& camera, const Vec3d& pivot_world, double about_up, double about_right);
/// About the view's axis, counter-clockwise as seen [radians].
Camera rolled(const Camera& camera, double angle);
/// So that a point at the pivot's depth moves by (dx, dy) pixels to the right and down.
Camera panned(const Camera& camera, const Vec3d& pivot_world, int height, double dx, double dy);
/// By `factor` < 1 nearer to what is seen at (x, y), which stays there; depth that of the pivot.
Camera zoomed(const Camera& camera, const Vec3d& pivot_world, int width, int height, double x,
              double y, double factor);
/// From the side of a world axis, as far from the pivot as now.
///
/// direction_to_eye  unit
Camera seen_from(const Camera& camera, const Vec3d& pivot_world, const Vec3d& direction_to_eye,
                 const Vec3d& up);
/// Perspective for orthographic and back: what lies at the pivot's depth keeps its size.
Camera with_other_projection(const Camera& camera, const Vec3d& pivot_world);

} // namespace isocast::view
