// Share of a light that reaches each hit.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/pixel.glsl"
#include "shading/shadow/shadow.glsl"

layout(binding = 0) uniform sampler2D t_hit;
layout(binding = 1) uniform sampler2D t_gradient;
uniform mat3 u_ray_vector; // world axes, affine in the pixel: towards the scene

out vec2 o_shadow; // share of the light, samples taken

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 hit = texelFetch(t_hit, pixel, 0);
    vec3 gradient = texelFetch(t_gradient, pixel, 0).xyz;
    o_shadow = light_share(hit.w != 0.0, hit.xyz, gradient, u_ray_vector * vec3(1.0, picture_pixel()));
}
