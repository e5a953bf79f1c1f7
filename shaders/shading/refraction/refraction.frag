// What is seen through the surface, by one refraction (thesis section 6.4.2, "Shading from gradient
// image").
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/effects/refraction.cpp
#version 450 core
#include "common/pixel.glsl"
#include "shading/environment/environment.glsl"
#include "shading/environment/spread.glsl"

uniform float u_index; // of the object; 1 outside

out vec4 o_refraction; // linear RGB, share

void main() {
    Surface surface = surface_at_pixel();
    vec3 direction =
        refract(surface.view, surface.normal, surface.is_inside ? u_index : 1.0 / u_index);
    // Total reflection.
    if (direction == vec3(0.0)) direction = reflect(surface.view, surface.normal);
    vec3 light = environment(direction, spread(direction, surface));
    o_refraction = surface.object != 0.0 ? vec4(light, 1.0) : vec4(0.0);
}
