// Principal curvatures and directions of given derivatives: for the checks of hard cases.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "filtering/principal_direction.glsl"

layout(local_size_x = 64) in;
// Of each point the gradient and the columns of the Hessian; k1, k2, then the direction of k1, that
// of k2.
layout(std430, binding = 0) readonly buffer Derivatives { vec4 derivatives[][4]; };
layout(std430, binding = 1) writeonly buffer Curvatures { vec4 curvatures[][3]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= derivatives.length()) return;
    mat3 hessian =
        mat3(derivatives[i][1].xyz, derivatives[i][2].xyz, derivatives[i][3].xyz);
    ShapeOperator s = shape_operator(derivatives[i][0].xyz, hessian);
    vec2 k = principal_curvatures(s);
    vec3 direction = principal_direction(s, k.x);
    curvatures[i][0] = vec4(k, 0.0, 0.0);
    curvatures[i][1] = vec4(direction, 0.0);
    curvatures[i][2] = vec4(cross(normalize(derivatives[i][0].xyz), direction), 0.0);
}
