// The colour of a splat's hit, found where it is rasterised (thesis table 7.3: direct shading).
// SPDX-License-Identifier: MPL-2.0
// twin  shading/shading.frag, which does it once a pixel
#include "common/pixel.glsl" // before #if, since a file is included once
#include "shading/normal.glsl"
#include "shading/blinn_phong/blinn_phong.glsl"
//
// HAS_SHADOW: whether a light casts any.
#if HAS_SHADOW
#include "shading/shadow/shadow.glsl"
uniform float u_shadow_strength;
uniform int u_shadowed_light;
#endif

uniform mat3 u_ray_vector; // world axes, affine in the pixel: towards the scene
uniform mat3 u_world_from_view;
flat in vec3 v_colour;
#if KIND == 2
flat in vec3 v_colour_b;
#else
const vec3 v_colour_b = vec3(0.0);
#endif

// is_b  it is in the other half of a stick
// p     where, in view space
vec3 direct_colour(QuadricHit hit, bool is_b, vec3 p) {
    vec3 normal = u_world_from_view * hit.normal;
    vec3 direction = u_ray_vector * vec3(1.0, picture_pixel());
    ShadowOfLight shadow = ShadowOfLight(-1, 1.0);
#if HAS_SHADOW
    float share = light_share(true, u_world_from_view * p, normal, direction).x;
    shadow = ShadowOfLight(u_shadowed_light, mix(1.0, share, u_shadow_strength));
#endif
    vec3 to_viewer = -normalize(direction);
    return lit(is_b ? v_colour_b : v_colour, facing_normal(normal, to_viewer), to_viewer, 1.0, shadow);
}
