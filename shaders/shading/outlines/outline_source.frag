// Normals and depths for outlines.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/pixel.glsl"

layout(binding = 0) uniform sampler2D t_hit;
layout(binding = 1) uniform sampler2D t_gradient;
uniform mat3 u_ray_vector; // world axes, affine in the pixel: towards the scene
uniform bool u_is_perspective;
uniform vec3 u_forward;
uniform float u_background_depth; // of parallel rays

// Normal, nearness. Normals are as long as lines are strong: not at all on what is 4 pixels wide, which
// they would blacken, fully from 12 on.
out vec4 o_outline_source;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 hit = texelFetch(t_hit, pixel, 0);
    vec4 gradient_width = texelFetch(t_gradient, pixel, 0);
    vec3 gradient = gradient_width.xyz;
    float strength = clamp(2.0 * gradient_width.w - 0.5, 0.0, 1.0);
    float length_g = length(gradient);
    vec3 ray = u_ray_vector * vec3(1.0, picture_pixel());
    float depth = dot(hit.xyz, u_forward);
    // Affine over the picture of a plane, and 0 at the background: infinitely far from an eye.
    float nearness = u_is_perspective ? 1.0 / depth : u_background_depth - depth;
    o_outline_source =
        hit.w == 0.0 ? vec4(0.0)
                     : vec4(strength * (length_g > 0.0 ? gradient / length_g : -normalize(ray)), nearness);
}
