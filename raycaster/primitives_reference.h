// A double ray caster for primitives, which pictures are checked against.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/cut.h"
#include "quadrics/primitives.h"
#include "raycaster/camera.h"

#include <limits>
#include <optional>
#include <vector>

namespace isocast {

/// What a ray meets first: a primitive by its number, kind by kind in the order of Primitives and
/// of meshes the mesh, or -1; how far along camera_ray()'s direction; and the unit normal
/// there.
struct SeenPrimitive {
    int number = -1;
    double t = std::numeric_limits<double>::infinity();
    Vec3d normal = Vec3d::Zero();
    Vec3d shaded_normal = Vec3d::Zero(); // of triangles that of their corners; unit length
    Vec3d colour = Vec3d::Zero();
};

/// Of each pixel of a picture, or of a part of it, the top row first. Each ray is tried against
/// every primitive that its pixel is near to: of spheres in a cone half as wide again as the one
/// that holds them, of others in the rectangle of screen_bounds() and 3 pixels around it.
///
/// with_dots   checked primitives
/// cut         checked; of caps where a ray is in several solids, that of depth_inside()'s least
/// source      spheres by their closest approach to the ray, triangles by the volumes that it spans
///             with their edges, others by intersect(), in double: of patches and tetrahedra by
///             other equations than the shaders', of SLIM surfaces blended()
std::vector<SeenPrimitive> cast_primitives(const Primitives& with_dots, const Camera& camera,
                                           int width, int height, const Cut& cut = {},
                                           const std::optional<PicturePart>& part = {});

} // namespace isocast
