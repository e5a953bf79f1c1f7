// Every site that may be the nearest of a sample: mostly one.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "distance/section.glsl"

flat in vec4 v_value;
flat in vec4 v_along_x;
flat in vec4 v_along_y;
flat in vec2 v_first_pixel;
flat in float v_error;
flat in ivec4 v_sample;
flat in int v_site;

layout(std430, binding = 2) buffer Count { uint count; };
layout(std430, binding = 3) writeonly buffer Candidates { uvec2 candidates[]; }; // sample, site
layout(binding = 0) uniform sampler2D t_bound;
uniform float u_half_width;

void main() {
    vec2 d = gl_FragCoord.xy - v_first_pixel;
    Reach reach = reach_of(v_value + v_along_x * d.x + v_along_y * d.y);
    if (reach.outside > v_error) return;
    float bound = min(texelFetch(t_bound, ivec2(gl_FragCoord.xy), 0).r, u_half_width);
    if (reach.distance - v_error > bound) return;
    uint at = atomicAdd(count, 1u);
    // A count beyond the capacity tells that the buffer is too small.
    if (at >= uint(candidates.length())) return;
    // Blocks of 8^3 samples, 4^3 of them in a tile.
    ivec3 p = ivec3(v_sample.xy + ivec2(d), v_sample.z);
    ivec3 block = p >> 3;
    ivec3 within = p & 7;
    int block_number = ((v_sample.w * 4 + block.z) * 4 + block.y) * 4 + block.x;
    int sample_number = (block_number << 9) + within.x + 8 * within.y + 64 * within.z;
    candidates[at] = uvec2(sample_number, v_site);
}
