// Contours of even thickness [Kindlmann et al. 2003].
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/pixel.glsl"
// A pixel's distance from the contour follows from n.v and the normal curvature k in the direction
// of the view, as if the surface went on as the circle of that curvature:
//
//            e      <- contour, where the ray touches the circle
//          . |
//        .   | w    c = n.v, s = sqrt(1 - c^2), d from the eye to the hit
//   n \ .    |
//      p ----+----> v
//
//   parallel rays    w = (1 - s)/k = c^2/(k (1 + s))
//   from an eye      w = c^2/(k + c/d + s sqrt(k (k + 2 c/d)))
//
// The second is d sin(asin(r/D) - asin(r s/D)), D from the eye to the middle of the circle of radius
// r = 1/k, without its cancellation; with 1/d = 0 it is the first. w <= T of the first is Kindlmann's
// c <= sqrt(T k (2 - T k)). On a plane, k = 0, the contour is the horizon. Where k changes along the
// view, so does the width: by k'/k^2 c of it, which is less the smaller T k is.

layout(binding = 0) uniform sampler2D t_hit;
layout(binding = 1) uniform sampler2D t_gradient;
layout(binding = 2) uniform sampler2D t_view_curvature;
uniform mat3 u_ray_vector; // world axes, affine in the pixel: towards the scene
uniform vec3 u_forward;
uniform bool u_is_perspective;
uniform float u_pixels_per_world; // of parallel rays; else at depth 1
uniform float u_thickness;        // T [pixels]
uniform vec3 u_colour;

out vec4 o_contours; // linear RGB, coverage

void main() {
    o_contours = vec4(0.0);
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 hit = texelFetch(t_hit, pixel, 0);
    vec3 gradient = texelFetch(t_gradient, pixel, 0).xyz;
    float length_g = length(gradient);
    if (hit.w == 0.0 || length_g == 0.0) return;
    vec3 ray = u_ray_vector * vec3(1.0, picture_pixel());
    vec3 v = -normalize(ray);
    // Seen from inside, what is convex is concave.
    float side = dot(gradient, v) < 0.0 ? -1.0 : 1.0;
    vec3 n = side * gradient / length_g;
    // Nothing that is concave hides itself; the contour is then as far as on a plane.
    float k = max(side * texelFetch(t_view_curvature, pixel, 0).x, 0.0);

    float c = dot(n, v);
    vec3 outwards = n - c * v;
    float s = length(outwards);
    float nearness = u_is_perspective ? 1.0 / length(hit.xyz) : 0.0;
    float w = c * c / max(k + c * nearness + s * sqrt(k * (k + 2.0 * c * nearness)), 1e-30);

    // A length along `outwards`, projected from the eye to the plane of the picture.
    vec3 projected = outwards - ray * (dot(outwards, u_forward) / dot(ray, u_forward));
    float pixels_per_world = u_pixels_per_world * (s > 0.0 ? length(projected) / s : 1.0);
    if (u_is_perspective) pixels_per_world /= dot(hit.xyz, u_forward);

    // What is thin keeps a light middle, and a dent of noise is no contour: at most a quarter of each
    // radius is line.
    float thickness = min(u_thickness, 0.25 * pixels_per_world / max(k, 1e-30));
    o_contours = vec4(u_colour, clamp(thickness - w * pixels_per_world + 0.5, 0.0, 1.0));
}
