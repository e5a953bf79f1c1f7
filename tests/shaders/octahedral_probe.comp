// There and back again: directions in 32 bits.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/octahedral.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Directions { vec4 directions[]; };
layout(std430, binding = 1) writeonly buffer Results { vec4 results[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= directions.length()) return;
    results[i] = vec4(unpacked_direction(packed_direction(directions[i].xyz)), 0.0);
}
