// Derivatives of the field at each hit, turned to world space, and what follows from them (thesis
// section 6.4.1).
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "raycast/field.glsl"
// ORDER 1: the gradient, 2: principal curvatures, 3: the direction of the first.
#if ORDER > 1
#include "filtering/curvature.glsl"
#endif
#if ORDER == 3
#include "filtering/principal_direction.glsl"
#endif
#if IS_STREAMED
#include "raycast/stream.glsl"
#endif

layout(binding = 3) uniform sampler2D t_hit;
uniform mat3 u_index_from_world;
uniform vec3 u_eye_local;
#if ORDER == 1
uniform float u_world_from_stored; // what a stored unit is
#else
uniform vec2 u_entry_error;      // see entry_error()
uniform float u_difference_error; // of k1 - k2 for that of an entry and a gradient of 1 [voxel^2/world^2]
#endif

// ORDER 1: gradient, world axes; w 1 on a hit
// ORDER 2: k1 >= k2 [1/world], 0; on a hit w 1, but 2 where the gradient vanishes, and k1 = k2 = 0,
//          and 3 at umbilics, both as far as roundings can tell
// ORDER 3: direction of k1, unit, world axes; w how far the curvatures differ: (k1 - k2) by
//          |k1| + |k2|, less what roundings can make; zero where the gradient vanishes
out vec4 o_derived;

#if ORDER > 1
// Bound of the error of an entry of the Hessian [stored units/voxel^2] and of the gradient's
// [stored units/voxel]: roundings of sums of 64 products, and what the samples themselves err.
float entry_error(Derivatives f) { return u_entry_error.x * f.greatest + u_entry_error.y; }
#endif

void main() {
    o_derived = vec4(0.0);
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
        // Inverse transpose of world_from_index: voxels need not be cubes.
#if ORDER == 1
        vec3 gradient_index = u_world_from_stored * field_gradient(p_local);
        o_derived = vec4(transpose(u_index_from_world) * gradient_index, 1.0);
#else
        Derivatives f = field_derivatives(p_local);
        float error = entry_error(f);
        bool has_normal = dot(f.gradient, f.gradient) > 3.0 * error * error;
        vec3 gradient = has_normal ? transpose(u_index_from_world) * f.gradient : vec3(0.0, 0.0, 1.0);
        mat3 hessian = transpose(u_index_from_world) * f.hessian * u_index_from_world;
        ShapeOperator s = shape_operator(gradient, hessian);
        vec2 k = principal_curvatures(s);
        float excess = k.x - k.y - u_difference_error * error / length(gradient);
#if ORDER == 2
        o_derived = has_normal ? vec4(k, 0.0, excess > 0.0 ? 1.0 : 3.0) : vec4(0.0, 0.0, 0.0, 2.0);
#else
        float differ = excess > 0.0 ? excess / (abs(k.x) + abs(k.y)) : 0.0;
        o_derived = has_normal ? vec4(principal_direction(s, k.x), differ) : vec4(0.0);
#endif
#endif
        is_waiting = o_derived.w < hit.w - 1e3; // never
    }
}
