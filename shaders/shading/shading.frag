// The picture: the surface's colour, lit, with the layers that effects made (thesis section 6.4.2).
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/shading.cpp
#version 450 core
#include "common/pixel.glsl"
#include "shading/lights.glsl" // before #if, since a file is included once
#include "shading/normal.glsl"
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
#if OBJECTS == 1
uniform vec3 u_colours[1]; // of the surface
#else
uniform vec3 u_colours[2 * OBJECTS]; // of each object's surface, and of each where it is taken away
#endif
uniform vec3 u_background;

out vec4 o_beauty; // linear RGB, coverage

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 direction = u_ray_vector * vec3(1.0, picture_pixel());
    float object = texelFetch(t_hit, pixel, 0).w;
    if (object == 0.0) {
#if SHOWS_ENVIRONMENT
        o_beauty = with_overlays(pixel, vec4(environment(direction, length(u_ray_vector[1]) / length(direction)), 0.0));
#else
        o_beauty = with_overlays(pixel, vec4(u_background, 0.0));
#endif
        return;
    }
    int number = int(abs(object)) - 1;
    vec3 colour = surface_colour(pixel, u_colours[object < 0.0 ? OBJECTS + number : number]);
#if MODEL != 2
    vec3 to_viewer = -normalize(direction);
    vec3 gradient = texelFetch(t_gradient, pixel, 0).xyz;
    colour = lit(colour, facing_normal(gradient, to_viewer), to_viewer, ambient_share(pixel), shadow(pixel));
#endif
    o_beauty = with_overlays(pixel, vec4(colour, 1.0));
}
