// Primitives that are drawn in many ways.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"

#include <utility>
#include <vector>

namespace isocast::stability {

/// One of each kind but triangles, of about size 1.
inline std::vector<std::pair<const char*, Primitives>> each_kind() {
    return {
        {"sphere", {.spheres = {{}}}},
        {"ellipsoid", {.ellipsoids = {{.axes_world = Vec3d(1, 0.5, 0.2).asDiagonal()}}}},
        {"cylinder",
         {.cylinders = {{.a_world = {-1, -0.3, 0.2},
                         .b_world = {0.9, 0.4, 0},
                         .radius_world = 0.3,
                         .is_capped = true}}}},
        {"cone", {.cones = {{.a_world = {-1, -0.3, 0.2}, .b_world = {0.9, 0.4, 0}}}}},
        {"quadric", {.quadrics = {{.a = Vec3d(1, 1, -1).asDiagonal(), .c = -0.1}}}},
    };
}

/// Around the eye, which looks along -z, and from in front of its plane to behind.
inline Primitives around_the_eye(const Vec3d& eye) {
    Primitives some;
    some.spheres = {{.centre_world = eye + Vec3d(0.9, 0, 0.1), .radius_world = 0.5},
                    {.centre_world = eye + Vec3d(-0.8, 0.2, -0.1), .radius_world = 0.6},
                    {.centre_world = eye + Vec3d(0, 0.1, 0.3), .radius_world = 4}};
    some.ellipsoids = {
        {.centre_world = eye + Vec3d(0, -0.5, 0), .axes_world = Vec3d(0.3, 0.4, 2).asDiagonal()}};
    some.cylinders = {{.a_world = eye + Vec3d(0.3, 0.4, 1),
                       .b_world = eye + Vec3d(0.4, 0.5, -2),
                       .radius_world = 0.2,
                       .is_capped = true}};
    some.cones = {{.a_world = eye + Vec3d(-0.3, 0.4, 1), .b_world = eye + Vec3d(-0.5, 1, -3)}};
    some.quadrics = {{.centre_world = eye + Vec3d(0.2, -0.9, 0),
                      .a = Vec3d(2, 2, 0).asDiagonal(),
                      .b = {0, 0, 0.4},
                      .c = 0}};
    return some;
}

} // namespace isocast::stability
