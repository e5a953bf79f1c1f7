// What searches of a block and traversals share.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/blocks.glsl"

// 1 / direction; a zero component counts as a tiny positive one: its planes are never reached.
vec3 inverse_of(vec3 direction) {
    return 1.0 / mix(direction, vec3(1e-30), equal(direction, vec3(0.0))); // 1e-30: 1/x is finite
}

// Parameters at which the ray enters and leaves a box. Faces that two boxes share give the same.
vec2 clip_to_box(vec3 point, vec3 inverse, vec3 lo, vec3 hi) {
    vec3 t0 = (lo - point) * inverse;
    vec3 t1 = (hi - point) * inverse;
    vec3 t_in = min(t0, t1);
    vec3 t_out = max(t0, t1);
    return vec2(max(t_in.x, max(t_in.y, t_in.z)), min(t_out.x, min(t_out.y, t_out.z)));
}
