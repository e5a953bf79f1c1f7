// Silhouettes and creases: Sobel filters of depths and normals (thesis section 7.3.3).
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/pixel.glsl"
// The stencil is that of four means, each of four texels around a corner of the pixel: what two of
// them share is counted twice. The thesis takes them by four bilinear fetches, whose weights depend on
// how the place in the texture is rounded, so that parts of a picture would not fit.
//
//   -1 -2 -1       -A- -B-
//    0  0  0  = 4 (       )     (figure 7.6, which has its fetches elsewhere)
//    1  2  1        C   D

layout(binding = 0) uniform sampler2D t_source; // normal, nearness: outline_source.frag
uniform mat3 u_ray_vector;                      // world axes, affine in the pixel
uniform bool u_is_perspective;
uniform vec3 u_pixel_x; // from a pixel to the next [world], of parallel rays; else at depth 1
uniform vec3 u_pixel_y;
uniform float u_silhouette_threshold; // a step of depth [world]
uniform float u_crease_threshold;     // a step of unit normals
uniform vec3 u_colour;

out vec4 o_outlines; // linear RGB, coverage

vec4 sources[9]; // of the pixel and those around it

void fetch_sources() {
    for (int i = 0; i < 9; ++i) {
        ivec2 place = ivec2(gl_FragCoord.xy) + ivec2(i % 3, i / 3) - 1;
        sources[i] = texelFetch(t_source, clamp(place, ivec2(0), textureSize(t_source, 0) - 1), 0);
    }
}

// The mean around a corner of the pixel.
//
// x, y  -1 or 1
vec4 corner(int x, int y) {
    return 0.25 * ((sources[4] + sources[4 + x + 3 * y]) + (sources[4 + x] + sources[4 + 3 * y]));
}

// How strong lines are on the nearest of what the stencil sees: a silhouette is that one's.
float strength_of_nearest() {
    vec4 nearest = sources[4];
    for (int i = 0; i < 9; ++i) nearest = sources[i].w > nearest.w ? sources[i] : nearest;
    return min(length(nearest.xyz), 1.0); // not a rounding more
}

// Clamped and linear, half at the threshold.
float ramp(float step, float threshold) {
    return clamp(step / threshold - 0.5, 0.0, 1.0);
}

void main() {
    fetch_sources();
    vec4 a = corner(-1, -1);
    vec4 b = corner(1, -1);
    vec4 c = corner(-1, 1);
    vec4 d = corner(1, 1);
    // A quarter of Sobel's response to a straight edge is the step.
    vec4 step_x = b + d - a - c;
    vec4 step_y = c + d - a - b;
    float crease = sqrt(dot(step_x.xyz, step_x.xyz) + dot(step_y.xyz, step_y.xyz));

    // Beside the plane through the pixel's point, which rises by `plane` from pixel to pixel. Half as
    // much is a slack for surfaces that bend: the slope of a circle from 1 to 3 pixels within its
    // silhouette is a quarter more than that at 2.
    vec4 centre = sources[4];
    float along_ray = dot(centre.xyz, u_ray_vector * vec3(1.0, picture_pixel()));
    float stable = along_ray < 0.0 ? min(along_ray, -1e-6) : max(along_ray, 1e-6);
    vec2 plane = vec2(dot(centre.xyz, u_pixel_x), dot(centre.xyz, u_pixel_y)) / stable;
    if (u_is_perspective) plane *= centre.w;
    float jump = max(0.0, length(vec2(step_x.w, step_y.w) - 2.0 * plane) - length(plane));
    if (u_is_perspective) {
        float near = max(max(a.w, b.w), max(c.w, d.w));
        // Of depths: 1/(near - jump) - 1/near, and beyond all bounds where that is the background.
        jump /= max(near * (near - jump), 1e-30);
    }
    float silhouette = strength_of_nearest() * ramp(jump, u_silhouette_threshold);
    o_outlines = vec4(u_colour, max(silhouette, ramp(crease, u_crease_threshold)));
}
