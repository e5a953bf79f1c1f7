// What is summed over the pieces of the sheet of a SLIM surface that shows, and the hit that it means.
// SPDX-License-Identifier: MPL-2.0
// twin  quadrics/slim_blend.h: blended()
#include "quadrics/quadric.glsl"

// Normals by their stereographic pictures, from the axis that faces the eye: two numbers instead of three,
// smooth and well conditioned to where a sheet turns away. So distances and the weight fit beside them.
//
// nearest  as FrameImage::SlimNearest
vec4 slim_sum(vec2 nearest, float t, vec3 normal, float weight) {
    vec3 n = nearest.y < 0.0 ? -normal : normal;
    const float least_rise = 1e-3; // quadrics/slim_blend.h
    return vec4(n.xy / max(1.0 + n.z, least_rise), t - nearest.x, 1.0) * weight;
}

// Unit normal, t; t is nowhere if nothing was summed.
vec4 slim_hit(vec2 nearest, vec4 sum) {
    if (sum.w <= 0.0) return vec4(0.0, 0.0, 0.0, nowhere);
    vec3 mean = sum.xyz / sum.w;
    float square = dot(mean.xy, mean.xy);
    vec3 n = vec3(2.0 * mean.xy, 1.0 - square) / (1.0 + square);
    return vec4(nearest.y < 0.0 ? -n : n, nearest.x + mean.z);
}
