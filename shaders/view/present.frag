// The canvas to the window, in sRGB.
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(binding = 0) uniform sampler2D t_canvas; // linear

layout(location = 0) out vec4 o_colour;

// IEC 61966-2-1.
vec3 srgb(vec3 linear) {
    return mix(12.92 * linear, 1.055 * pow(max(linear, 0.0031308), vec3(1.0 / 2.4)) - 0.055,
               step(0.0031308, linear));
}

void main() {
    o_colour = vec4(srgb(clamp(texelFetch(t_canvas, ivec2(gl_FragCoord.xy), 0).rgb, 0.0, 1.0)), 1.0);
}
