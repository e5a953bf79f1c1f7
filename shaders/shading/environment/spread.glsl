// How far apart neighbouring pixels look.
// SPDX-License-Identifier: MPL-2.0

// The greater angle between the directions of this pixel and of its neighbours in the quad on the
// same object; for all pixels of the quad to call.
float spread(vec3 unit_direction, float object) {
    vec2 angles = vec2(length(dFdx(unit_direction)), length(dFdy(unit_direction)));
    vec2 is_edge = abs(vec2(dFdx(object), dFdy(object)));
    return max(is_edge.x > 0.0 ? 0.0 : angles.x, is_edge.y > 0.0 ? 0.0 : angles.y);
}
