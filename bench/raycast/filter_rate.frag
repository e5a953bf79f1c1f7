// Samples along straight lines, one line a pixel: what a filter costs by itself.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "filtering/tricubic.glsl"

// METHOD 0: value by this kernel, 1: value and slope by it, 2: value by the GL's linear filter.
layout(binding = 5) uniform sampler3D t_volume;
uniform int u_samples;      // of a pixel
uniform float u_from_pixel; // voxels

out vec4 o_sum;

const float extent = 64.0; // samples along each axis; bench/raycast/filter_rate.cpp

void main() {
    vec3 p = vec3(4.0 + u_from_pixel * gl_FragCoord.xy, 4.0);
    vec3 d = vec3(0.1, 0.2, 0.97);
    float step = 48.0 / float(u_samples);
    vec2 sum = vec2(0.0);
    for (int i = 0; i < u_samples; ++i) {
        vec3 q = p + (float(i) * step) * d;
#if METHOD == 2
        sum.x += texture(t_volume, (q + 0.5) / extent).r;
#else
        vec3 cell = floor(q);
        ivec3 c = ivec3(cell) - 1;
        int address = c.x + ROW_STRIDE * c.y + PLANE_STRIDE * c.z;
#if METHOD == 0
        sum.x += fast_value_and_slope(address, q - cell, d).x;
#elif METHOD == 1
        sum += fast_value_and_slope(address, q - cell, d);
#else
#error unknown METHOD
#endif
#endif
    }
    o_sum = vec4(sum, 0.0, 0.0);
}
