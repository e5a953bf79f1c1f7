// How far apart neighbouring pixels look.
// SPDX-License-Identifier: MPL-2.0
#include "shading/surface.glsl"

// The greater angle between the directions of this pixel and of its neighbours in the quad on the
// same object, and at least that between their views; for all pixels of the quad to call.
float spread(vec3 unit_direction, Surface surface) {
    vec2 angles = vec2(length(dFdx(unit_direction)), length(dFdy(unit_direction)));
    vec2 is_edge = abs(vec2(dFdx(surface.object), dFdy(surface.object)));
    return max(surface.view_angle,
               max(is_edge.x > 0.0 ? 0.0 : angles.x, is_edge.y > 0.0 ? 0.0 : angles.y));
}
