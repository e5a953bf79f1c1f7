// What an effect knows of the surface at its pixel.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/effects/effects.cpp: set_surface_uniforms()
#include "common/pixel.glsl"
#include "shading/normal.glsl"

layout(binding = 0) uniform sampler2D t_hit;
layout(binding = 1) uniform sampler2D t_gradient;
uniform mat3 u_ray_vector; // world axes, affine in the pixel: towards the scene

struct Surface {
    float object;     // 0: none
    vec3 point;       // from the eye [world]
    vec3 view;        // unit length, towards the scene
    float view_angle; // to the next pixel's, at most
    vec3 normal;      // unit length, against `view`
    bool is_inside;   // the viewer, of the object
};

Surface surface_at_pixel() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 hit = texelFetch(t_hit, pixel, 0);
    vec3 ray = u_ray_vector * vec3(1.0, picture_pixel());
    vec3 view = normalize(ray);
    vec3 gradient = texelFetch(t_gradient, pixel, 0).xyz;
    return Surface(hit.w, hit.xyz, view, length(u_ray_vector[1]) / length(ray),
                   facing_normal(gradient, -view), dot(gradient, view) > 0.0);
}
