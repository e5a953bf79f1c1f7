// Ridges and valleys in the domain of principal curvatures [Kindlmann et al. 2003].
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(binding = 0) uniform sampler2D t_curvature;
uniform float u_threshold; // [1/world]
uniform vec3 u_ridge_colour;
uniform vec3 u_valley_colour;

out vec4 o_ridges; // linear RGB, coverage

void main() {
    vec2 k = texelFetch(t_curvature, ivec2(gl_FragCoord.xy), 0).xy;
    // A ridge bends much across and little along, outwards; a valley inwards. Two wedges of the
    // domain about the axes of k1 > 0 and of k2 < 0, which do not meet.
    float ridge = k.x - abs(k.y);
    float valley = -k.y - abs(k.x);
    vec3 colour = ridge > valley ? u_ridge_colour : u_valley_colour;
    o_ridges = vec4(colour, smoothstep(0.75 * u_threshold, 1.25 * u_threshold, max(ridge, valley)));
}
