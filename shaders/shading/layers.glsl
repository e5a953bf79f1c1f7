// The images that effects made, by what shading does with them.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/shading.h: Blend
#include "shading/lights.glsl"
//
// SURFACE_LAYERS, SURFACE_FACTORS, AMBIENT_FACTORS, SHADOWS (at most one), OVERLAYS: how many of each.

#if SURFACE_LAYERS
layout(binding = 2) uniform sampler2D t_surface_layers[SURFACE_LAYERS];
uniform float u_surface_strengths[SURFACE_LAYERS];
#endif
#if SURFACE_FACTORS
layout(binding = 2 + SURFACE_LAYERS) uniform sampler2D t_surface_factors[SURFACE_FACTORS];
uniform float u_factor_strengths[SURFACE_FACTORS];
#endif
// Before the first of the light's factors.
const int light_unit = 2 + SURFACE_LAYERS + SURFACE_FACTORS;
#if AMBIENT_FACTORS
layout(binding = light_unit) uniform sampler2D t_ambient_factors[AMBIENT_FACTORS];
uniform float u_ambient_strengths[AMBIENT_FACTORS];
#endif
#if SHADOWS
layout(binding = light_unit + AMBIENT_FACTORS) uniform sampler2D t_shadows[SHADOWS];
uniform float u_shadow_strengths[SHADOWS];
uniform int u_shadowed_light;
#endif
#if OVERLAYS
layout(binding = light_unit + AMBIENT_FACTORS + SHADOWS) uniform sampler2D
    t_overlays[OVERLAYS];
uniform float u_overlay_strengths[OVERLAYS];
#endif

vec3 surface_colour(ivec2 pixel, vec3 colour) {
#if SURFACE_LAYERS
    for (int i = 0; i < SURFACE_LAYERS; ++i) {
        vec4 layer = texelFetch(t_surface_layers[i], pixel, 0);
        colour = mix(colour, layer.rgb, u_surface_strengths[i] * layer.a);
    }
#endif
#if SURFACE_FACTORS
    for (int i = 0; i < SURFACE_FACTORS; ++i) {
        vec4 layer = texelFetch(t_surface_factors[i], pixel, 0);
        colour *= mix(1.0, layer.r, u_factor_strengths[i] * layer.a);
    }
#endif
    return colour;
}

// Share of the ambient light that reaches the pixel's surface.
float ambient_share(ivec2 pixel) {
    float share = 1.0;
#if AMBIENT_FACTORS
    for (int i = 0; i < AMBIENT_FACTORS; ++i)
        share *= mix(1.0, texelFetch(t_ambient_factors[i], pixel, 0).r, u_ambient_strengths[i]);
#endif
    return share;
}

// Share of one light that reaches it.
ShadowOfLight shadow(ivec2 pixel) {
#if SHADOWS
    return ShadowOfLight(u_shadowed_light,
                         mix(1.0, texelFetch(t_shadows[0], pixel, 0).r, u_shadow_strengths[0]));
#else
    return ShadowOfLight(-1, 1.0);
#endif
}

// colour  linear RGB, coverage
vec4 with_overlays(ivec2 pixel, vec4 colour) {
#if OVERLAYS
    for (int i = 0; i < OVERLAYS; ++i) {
        vec4 layer = texelFetch(t_overlays[i], pixel, 0);
        float share = u_overlay_strengths[i] * layer.a;
        colour = vec4(mix(colour.rgb, layer.rgb, share), max(colour.a, share));
    }
#endif
    return colour;
}
