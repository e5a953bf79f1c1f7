// What follows from the Hessian, each to its attachment, -1 for none.
// SPDX-License-Identifier: MPL-2.0
#include "common/pixel.glsl"
#include "filtering/curvature.glsl"
#if DIRECTION_AT >= 0
#include "filtering/principal_direction.glsl"
#endif

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

// Beside hits.
void write_nothing() {
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
}

// gradient, hessian  of a function that is constant on the surface, world axes
// has_normal         false: the gradient is nothing but roundings
// difference_error   of k1 - k2 [1/world]
void write_second_order(vec3 gradient, mat3 hessian, bool has_normal, float difference_error) {
#if VIEW_CURVATURE_AT >= 0
    o_view_curvature =
        normal_curvature(gradient, hessian, u_ray_vector_world * vec3(1.0, picture_pixel()));
#endif
#if FLOW_LINE_CURVATURE_AT >= 0
    o_flow_line_curvature = flow_line_curvature(gradient, hessian);
#endif
#if CURVATURE_AT >= 0 || DIRECTION_AT >= 0
    gradient = has_normal ? gradient : vec3(0.0, 0.0, 1.0);
    ShapeOperator s = shape_operator(gradient, hessian);
    vec2 k = principal_curvatures(s);
    float excess = k.x - k.y - difference_error;
#endif
#if CURVATURE_AT >= 0
    o_curvature = has_normal ? vec4(k, 0.0, excess > 0.0 ? 1.0 : 3.0) : vec4(0.0, 0.0, 0.0, 2.0);
#endif
#if DIRECTION_AT >= 0
    float differ = excess > 0.0 ? excess / (abs(k.x) + abs(k.y)) : 0.0;
    o_direction = has_normal ? vec4(principal_direction(s, k.x), differ) : vec4(0.0);
#endif
}
