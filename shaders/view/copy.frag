// A part of a picture to its place on the canvas, enlarged by bilinear interpolation.
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(binding = 0) uniform sampler2D t_from;
uniform vec2 u_to_origin;   // of the part, on the canvas [pixels]
uniform vec2 u_from_origin; // of the part, in t_from [texels]
uniform vec2 u_from_size;   // of the part [texels]
uniform vec2 u_scale;       // texels per pixel
uniform float u_most_steps; // above 0: t_from has numbers of steps, and this many are red

layout(location = 0) out vec4 o_colour;

// From dark blue by green and yellow to red.
vec3 heat(float x) {
    return clamp(vec3(2.0 * x - 0.6, 1.6 - abs(3.2 * x - 1.6), 1.0 - 2.5 * x), 0.0, 1.0);
}

vec4 colour_at(ivec2 texel) {
    vec4 texels = texelFetch(t_from, texel, 0);
    return u_most_steps > 0.0 ? vec4(heat(min(texels.r / u_most_steps, 1.0)), 1.0) : texels;
}

void main() {
    vec2 at = (gl_FragCoord.xy - u_to_origin) * u_scale - 0.5;
    at = clamp(at, vec2(0.0), u_from_size - 1.0);
    ivec2 low = ivec2(floor(at));
    ivec2 high = min(low + 1, ivec2(u_from_size) - 1);
    vec2 t = at - vec2(low);
    ivec2 from = ivec2(u_from_origin);
    vec4 below = mix(colour_at(from + low), colour_at(from + ivec2(high.x, low.y)), t.x);
    vec4 above = mix(colour_at(from + ivec2(low.x, high.y)), colour_at(from + high), t.x);
    o_colour = vec4(mix(below, above, t.y).rgb, 1.0);
}
