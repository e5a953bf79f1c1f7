// Derivatives of the field at each hit, turned to world space, and what follows from them (thesis
// section 6.4.1).
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/pixel.glsl"
#include "raycast/field.glsl"
// ORDER 1: the gradient; 2: what follows from the Hessian, each to its attachment, -1 for none.
#if ORDER == 2
#include "filtering/second_order.glsl"
#endif
#if IS_STREAMED
#include "raycast/stream.glsl"
#endif

layout(binding = 3) uniform sampler2D t_hit;
uniform mat3 u_index_from_world;
uniform vec3 u_eye_local;
#if IS_OPERAND
uniform int u_object; // of several, the one whose hits are looked at
#endif
#if ORDER == 1
uniform float u_world_from_stored; // what a stored unit is
#elif CURVATURE_AT >= 0 || DIRECTION_AT >= 0
uniform vec2 u_entry_error;      // see entry_error()
uniform float u_difference_error; // of k1 - k2 for that of an entry and a gradient of 1 [voxel^2/world^2]

// Bound of the error of an entry of the Hessian [stored units/voxel^2] and of the gradient's
// [stored units/voxel]: roundings of sums of 64 products, and what the samples themselves err.
float entry_error(Derivatives f) { return u_entry_error.x * f.greatest + u_entry_error.y; }
#endif

#if ORDER == 1
out vec4 o_gradient; // world axes; w 1 on a hit
#endif

void main() {
#if ORDER == 1
    o_gradient = vec4(0.0);
#else
    write_nothing();
#endif
    vec4 hit = texelFetch(t_hit, ivec2(gl_FragCoord.xy), 0);
    vec3 p_local = u_eye_local + u_index_from_world * hit.xyz;
#if IS_OPERAND
    // The composed function is the negative of an object that is taken away.
    float orientation = sign(hit.w);
    hit.w = int(abs(hit.w)) == u_object ? 1.0 : 0.0;
#endif
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
        // Inverse transpose of world_from_index: voxels need not be cubes.
#if ORDER == 1
        vec3 gradient_index = u_world_from_stored * field_gradient(p_local);
#if IS_OPERAND
        gradient_index *= orientation;
#endif
        o_gradient = vec4(transpose(u_index_from_world) * gradient_index, 1.0);
        is_waiting = o_gradient.w < hit.w - 1e3; // never
#else
        Derivatives f = field_derivatives(p_local);
#if IS_OPERAND
        f.gradient *= orientation;
        f.hessian *= orientation;
#endif
        is_waiting = f.gradient.x < hit.w - 1e30; // never
        vec3 gradient = transpose(u_index_from_world) * f.gradient;
        mat3 hessian = transpose(u_index_from_world) * f.hessian * u_index_from_world;
#if CURVATURE_AT >= 0 || DIRECTION_AT >= 0
        float error = entry_error(f);
        bool has_normal = dot(f.gradient, f.gradient) > 3.0 * error * error;
        write_second_order(gradient, hessian, has_normal, u_difference_error * error / length(gradient));
#else
        write_second_order(gradient, hessian, true, 0.0);
#endif
#endif
    }
#if IS_OPERAND
    if (hit.w == 0.0) discard;
#endif
}
