// The blended hit of a SLIM surface.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "quadrics/quadric.glsl"

layout(binding = 1) uniform sampler2D t_nearest;
layout(binding = 2) uniform sampler2D t_normals; // sums by weight, and of weights
layout(binding = 3) uniform sampler2D t_distances; // the same, from t_nearest on
out vec4 o_hit; // as FrameImage::SlimHit

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 sum = texelFetch(t_normals, pixel, 0);
    float t = texelFetch(t_nearest, pixel, 0).x + texelFetch(t_distances, pixel, 0).x / sum.w;
    o_hit = sum.w > 0.0 && sum.xyz != vec3(0.0) ? vec4(normalize(sum.xyz), t) : vec4(vec3(0.0), nowhere);
}
