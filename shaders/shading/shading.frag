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

#if OF_SPLATS // alone, of which nothing but shading looks at hits
#include "common/octahedral.glsl"
layout(binding = 0) uniform usampler2D t_surface;
layout(binding = 1) uniform samplerBuffer t_colours; // by primitive
uniform int u_to_half_colours; // from that of a stick to that of its half at b
uniform mat3 u_world_from_view;
#else
layout(binding = 0) uniform sampler2D t_hit;
layout(binding = 1) uniform sampler2D t_gradient;
#if OBJECTS == 1
uniform vec3 u_colours[1]; // of the surface
#else
uniform vec3 u_colours[2 * OBJECTS]; // of each object's surface, and of each where it is taken away
#endif
#endif
uniform mat3 u_ray_vector; // world axes, affine in the pixel: towards the scene
uniform vec3 u_background;

out vec4 o_beauty; // linear RGB, coverage

struct Shown {
    bool is_there;
    vec3 colour;
    vec3 gradient;
};

Shown shown_at(ivec2 pixel) {
#if OF_SPLATS
    uvec2 surface = texelFetch(t_surface, pixel, 0).xy;
    int number = max(int(surface.x & 0x7fffffffu) - 1, 0) + (int(surface.x) < 0 ? u_to_half_colours : 0);
    return Shown(surface.x != 0u, texelFetch(t_colours, number).rgb, u_world_from_view * unpacked_direction(surface.y));
#else
    float object = texelFetch(t_hit, pixel, 0).w;
    int number = max(int(abs(object)) - 1, 0);
#if MODEL == 2
    vec3 gradient = vec3(0.0);
#else
    vec3 gradient = texelFetch(t_gradient, pixel, 0).xyz;
#endif
    return Shown(object != 0.0, u_colours[object < 0.0 ? OBJECTS + number : number], gradient);
#endif
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 direction = u_ray_vector * vec3(1.0, picture_pixel());
    Shown shown = shown_at(pixel);
    if (!shown.is_there) {
#if SHOWS_ENVIRONMENT
        o_beauty = with_overlays(pixel, vec4(environment(direction, length(u_ray_vector[1]) / length(direction)), 0.0));
#else
        o_beauty = with_overlays(pixel, vec4(u_background, 0.0));
#endif
        return;
    }
    vec3 colour = surface_colour(pixel, shown.colour);
#if MODEL != 2
    vec3 to_viewer = -normalize(direction);
    colour = lit(colour, facing_normal(shown.gradient, to_viewer), to_viewer, ambient_share(pixel), shadow(pixel));
#endif
    o_beauty = with_overlays(pixel, vec4(colour, 1.0));
}
