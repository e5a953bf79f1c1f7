// Derivatives of the field at each hit, turned to world space, and what follows from them (thesis
// section 6.4.1).
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/pixel.glsl"
#include "raycast/field.glsl"
// ORDER 1: the gradient; 2: what follows from the Hessian, each to its attachment, -1 for none.
#if ORDER == 2
#include "filtering/curvature.glsl"
#endif
#if ORDER == 2
#if DIRECTION_AT >= 0
#include "filtering/principal_direction.glsl"
#endif
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
#endif

#if ORDER == 1
out vec4 o_gradient; // world axes; w 1 on a hit
#else
#if CURVATURE_AT >= 0
// k1 >= k2 [1/world], 0; on a hit w 1, but 2 where the gradient vanishes, and k1 = k2 = 0, and 3 at
// umbilics, both as far as roundings can tell
layout(location = CURVATURE_AT) out vec4 o_curvature;
#endif
#if DIRECTION_AT >= 0
// Of k1, unit, world axes; w how far the curvatures differ: (k1 - k2) by |k1| + |k2|, less what
// roundings can make; zero where the gradient vanishes
layout(location = DIRECTION_AT) out vec4 o_direction;
#endif
#if VIEW_CURVATURE_AT >= 0
layout(location = VIEW_CURVATURE_AT) out float o_view_curvature; // [1/world]
uniform mat3 u_ray_vector_world; // affine in the pixel
#endif
#if FLOW_LINE_CURVATURE_AT >= 0
layout(location = FLOW_LINE_CURVATURE_AT) out float o_flow_line_curvature; // [1/world]
#endif
#if CURVATURE_AT >= 0 || DIRECTION_AT >= 0
// Bound of the error of an entry of the Hessian [stored units/voxel^2] and of the gradient's
// [stored units/voxel]: roundings of sums of 64 products, and what the samples themselves err.
float entry_error(Derivatives f) { return u_entry_error.x * f.greatest + u_entry_error.y; }
#endif
#endif

void main() {
#if ORDER == 1
    o_gradient = vec4(0.0);
#else
#if CURVATURE_AT >= 0
    o_curvature = vec4(0.0);
#endif
#if DIRECTION_AT >= 0
    o_direction = vec4(0.0);
#endif
#if VIEW_CURVATURE_AT >= 0
    o_view_curvature = 0.0;
#endif
#if FLOW_LINE_CURVATURE_AT >= 0
    o_flow_line_curvature = 0.0;
#endif
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
#if VIEW_CURVATURE_AT >= 0
        o_view_curvature =
            normal_curvature(gradient, hessian, u_ray_vector_world * vec3(1.0, picture_pixel()));
#endif
#if FLOW_LINE_CURVATURE_AT >= 0
        o_flow_line_curvature = flow_line_curvature(gradient, hessian);
#endif
#if CURVATURE_AT >= 0 || DIRECTION_AT >= 0
        float error = entry_error(f);
        bool has_normal = dot(f.gradient, f.gradient) > 3.0 * error * error;
        gradient = has_normal ? gradient : vec3(0.0, 0.0, 1.0);
        ShapeOperator s = shape_operator(gradient, hessian);
        vec2 k = principal_curvatures(s);
        float excess = k.x - k.y - u_difference_error * error / length(gradient);
#endif
#if CURVATURE_AT >= 0
        o_curvature = has_normal ? vec4(k, 0.0, excess > 0.0 ? 1.0 : 3.0) : vec4(0.0, 0.0, 0.0, 2.0);
#endif
#if DIRECTION_AT >= 0
        float differ = excess > 0.0 ? excess / (abs(k.x) + abs(k.y)) : 0.0;
        o_direction = has_normal ? vec4(principal_direction(s, k.x), differ) : vec4(0.0);
#endif
#endif
    }
#if IS_OPERAND
    if (hit.w == 0.0) discard;
#endif
}
