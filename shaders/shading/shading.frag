// The picture: the surface's colour, lit, with the layers that effects made (thesis section 6.4.2).
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/shading.cpp
#version 450 core
#include "common/pixel.glsl"
#include "shading/lights.glsl" // before #if, since a file is included once
// MODEL: raycaster/look.h, ShadingModel.
#if MODEL == 0
#include "shading/blinn_phong/blinn_phong.glsl"
#elif MODEL == 1
#include "shading/gooch/gooch.glsl"
#elif MODEL != 2
#error unknown MODEL
#endif
#include "shading/layers.glsl"
#if SHOWS_ENVIRONMENT
#include "shading/environment/environment.glsl"
#endif

layout(binding = 0) uniform sampler2D t_hit;
layout(binding = 1) uniform sampler2D t_gradient;
uniform mat3 u_ray_vector; // world axes, affine in the pixel: towards the scene
uniform vec3 u_colour;     // of the surface
uniform vec3 u_background;

out vec4 o_beauty; // linear RGB, coverage

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 direction = u_ray_vector * vec3(1.0, picture_pixel());
    if (texelFetch(t_hit, pixel, 0).w == 0.0) {
#if SHOWS_ENVIRONMENT
        o_beauty = with_overlays(pixel, vec4(environment(direction), 0.0));
#else
        o_beauty = with_overlays(pixel, vec4(u_background, 0.0));
#endif
        return;
    }
    vec3 colour = surface_colour(pixel, u_colour);
#if MODEL != 2
    vec3 to_viewer = -normalize(direction);
    vec3 gradient = texelFetch(t_gradient, pixel, 0).xyz;
    float length_g = length(gradient);
    // Where the gradient vanishes there is no normal: the surface then faces the viewer.
    vec3 normal = length_g > 0.0 ? gradient / length_g : to_viewer;
    // Seen from inside, the surface shows its back.
    if (dot(normal, to_viewer) < 0.0) normal = -normal;
    colour = lit(colour, normal, to_viewer, ambient_share(pixel), shadow(pixel));
#endif
    o_beauty = with_overlays(pixel, vec4(colour, 1.0));
}
