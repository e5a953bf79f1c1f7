// What both searches of a block share.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/blocks.glsl"

// 1 / direction; a zero component counts as a tiny positive one: its planes are never reached.
vec3 inverse_of(vec3 direction) {
    return 1.0 / mix(direction, vec3(1e-30), equal(direction, vec3(0.0))); // 1e-30: 1/x is finite
}
