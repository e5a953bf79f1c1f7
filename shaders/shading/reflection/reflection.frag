// What the surface mirrors (thesis section 6.4.2, "Shading from gradient image").
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/effects/reflection.cpp
#version 450 core
#include "common/pixel.glsl"
#include "shading/environment/environment.glsl"
#include "shading/environment/spread.glsl"

#if HAS_FRESNEL
uniform float u_index; // of the object; 1 outside

// [Schlick 1994, eq. 15], with the cosine in the thinner of the two, from where everything is
// mirrored beyond the critical angle.
float reflectance(float cosine, float index) {
    float r0 = (index - 1.0) / (index + 1.0);
    r0 *= r0;
    if (index < 1.0) {
        float cosine2 = 1.0 - (1.0 - cosine * cosine) / (index * index);
        cosine = sqrt(max(cosine2, 0.0));
    }
    float away = 1.0 - cosine;
    float away2 = away * away;
    return r0 + (1.0 - r0) * away2 * away2 * away;
}
#endif

out vec4 o_reflection; // linear RGB, share

void main() {
    Surface surface = surface_at_pixel();
    vec3 direction = reflect(surface.view, surface.normal);
    vec3 light = environment(direction, spread(direction, surface));
#if HAS_FRESNEL
    float share = reflectance(-dot(surface.view, surface.normal),
                              surface.is_inside ? 1.0 / u_index : u_index);
#else
    float share = 1.0;
#endif
    o_reflection = surface.object != 0.0 ? vec4(light, share) : vec4(0.0);
}
