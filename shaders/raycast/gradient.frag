// Gradient of the field at each hit, turned to world space (thesis section 6.4.1).
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "raycast/field.glsl"
#if IS_STREAMED
#include "raycast/stream.glsl"
#endif

layout(binding = 3) uniform sampler2D t_hit;
uniform mat3 u_index_from_world;
uniform vec3 u_eye_local;
uniform float u_world_from_stored; // what a stored unit is

out vec4 o_gradient; // world axes; w 1 on a hit

void main() {
    o_gradient = vec4(0.0);
    vec4 hit = texelFetch(t_hit, ivec2(gl_FragCoord.xy), 0);
    vec3 p_local = u_eye_local + u_index_from_world * hit.xyz;
#if IS_STREAMED
    if (progress_of_pixel() == is_finished) discard;
    if (hit.w != 0.0) {
        uint word = word_at(block_of(p_local));
        int number = int(word & word_number);
        if (is_active(word) && !visit(number, fetch_block(number).address >= 0)) discard;
    }
    set_progress(is_finished);
#endif
    // A loop for a condition, since software rasterisers run both sides of a condition; what ends it
    // is computed, or the compiler would see that it runs but once.
    bool is_waiting = hit.w != 0.0;
    while (is_waiting) {
        vec3 gradient_index = u_world_from_stored * field_gradient(p_local);
        // Inverse transpose of world_from_index: voxels need not be cubes.
        o_gradient = vec4(transpose(u_index_from_world) * gradient_index, 1.0);
        is_waiting = o_gradient.w < hit.w - 1e3; // never
    }
}
