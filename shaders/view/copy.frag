// A part of a picture to its place: on the canvas, which is linear, or as the window shows it.
// SPDX-License-Identifier: MPL-2.0
#version 450 core

// IS_SHOWN: 1 for sRGB.

layout(binding = 0) uniform sampler2D t_from; // linear
uniform ivec2 u_from_to;                      // from the place to the texel
uniform float u_most_steps;                   // above 0: t_from has steps; this many are red

layout(location = 0) out vec4 o_colour;

// From dark blue by green and yellow to red.
vec3 heat(float x) {
    return clamp(vec3(2.0 * x - 0.6, 1.6 - abs(3.2 * x - 1.6), 1.0 - 2.5 * x), 0.0, 1.0);
}

// twin  raycaster/image.h: srgb_encoded
vec3 srgb(vec3 linear) {
    return mix(12.92 * linear, 1.055 * pow(max(linear, 0.0031308), vec3(1.0 / 2.4)) - 0.055,
               step(0.0031308, linear));
}

void main() {
    vec3 colour = texelFetch(t_from, ivec2(gl_FragCoord.xy) + u_from_to, 0).rgb;
    if (u_most_steps > 0.0) colour = heat(min(colour.r / u_most_steps, 1.0));
#if IS_SHOWN
    colour = srgb(clamp(colour, 0.0, 1.0));
#endif
    o_colour = vec4(colour, 1.0);
}
