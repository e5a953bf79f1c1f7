// Evaluates the production field functions at given points.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "raycast/field.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Points { vec4 points[]; };
layout(std430, binding = 1) writeonly buffer Results { vec4 results[]; }; // value, gradient

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= points.length()) return;
    results[i] = vec4(field_value(points[i].xyz), field_gradient(points[i].xyz));
}
