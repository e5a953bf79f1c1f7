// A plane that shows the field: tones by its value, and lines where that is a multiple of a distance.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/effects/slice.cpp
#version 450 core
#include "common/pixel.glsl"

layout(binding = 0) uniform sampler2D t_hit;
layout(binding = 1) uniform sampler3D t_values; // of the field [world]; none beyond its extent
// Affine in the pixel: x / z and y / z are the place in the texture [texels].
uniform mat3 u_texel_from_pixel;
uniform vec3 u_distance; // along the ray, times the same z
uniform vec4 u_plane;    // normal; offset from the eye [world]
uniform float u_tie;     // hits so far in front of the plane are in it [world]
uniform float u_iso;
uniform float u_spacing; // of lines [world]
uniform float u_range;   // from iso to the full tone [world]
uniform vec3 u_paper;    // at iso, linear RGB
uniform vec3 u_inside;
uniform vec3 u_outside;
uniform vec3 u_line;

out vec4 o_slice; // linear RGB, coverage

const float none = 1e30; // of slice.cpp

// Half widths of lines [pixels]: fine ones, and where the surface is.
const float fine = 0.5;
const float thick = 1.25;

float line(float value, float slope, float half_width) {
    return slope > 0.0 ? clamp(half_width + 0.5 - abs(value) / slope, 0.0, 1.0) : 0.0;
}

void main() {
    o_slice = vec4(0.0);
    vec3 place = vec3(1.0, picture_pixel());
    vec3 q = u_texel_from_pixel * place;
    float along = sign(q.z);
    bool is_in_front = along * dot(u_distance, place) > 0.0;
    vec2 texel = q.xy / q.z;
    vec2 last = vec2(textureSize(t_values, 0).xy - 1);
    bool is_inside_square = all(greaterThanEqual(texel, vec2(0.0))) && all(lessThan(texel, last));
    // What the ray meets before the plane hides it.
    vec4 hit = texelFetch(t_hit, ivec2(gl_FragCoord.xy), 0);
    bool is_hidden = hit.w != 0.0 && along * (dot(u_plane.xyz, hit.xyz) - u_plane.w) < -u_tie;
    if (!is_in_front || !is_inside_square || is_hidden) return;

    ivec3 corner = ivec3(floor(texel), 0);
    vec2 a = texel - vec2(corner.xy);
    float f00 = texelFetch(t_values, corner, 0).r;
    float f10 = texelFetch(t_values, corner + ivec3(1, 0, 0), 0).r;
    float f01 = texelFetch(t_values, corner + ivec3(0, 1, 0), 0).r;
    float f11 = texelFetch(t_values, corner + ivec3(1, 1, 0), 0).r;
    float value = mix(mix(f00, f10, a.x), mix(f01, f11, a.x), a.y);
    if (max(max(f00, f10), max(f01, f11)) >= none) return;
    vec2 gradient = vec2(mix(f10 - f00, f11 - f01, a.y), mix(f01 - f00, f11 - f10, a.x));
    // How fast it changes from pixel to pixel, by the quotients' derivatives.
    vec2 by_x = (u_texel_from_pixel[1].xy - texel * u_texel_from_pixel[1].z) / q.z;
    vec2 by_y = (u_texel_from_pixel[2].xy - texel * u_texel_from_pixel[2].z) / q.z;
    float slope = length(vec2(dot(gradient, by_x), dot(gradient, by_y)));

    float from_iso = value - u_iso;
    vec3 tone = mix(u_paper, from_iso < 0.0 ? u_inside : u_outside, min(abs(from_iso) / u_range, 1.0));
    // Where they would be nearer than 2 pixels they are a grey that says nothing: gone, and whole
    // from 6 pixels on.
    float shown = slope > 0.0 ? clamp(0.25 * (u_spacing / slope) - 0.5, 0.0, 1.0) : 0.0;
    float fine_line = shown * line(value - u_spacing * round(value / u_spacing), slope, fine);
    o_slice = vec4(mix(tone, u_line, max(0.6 * fine_line, line(from_iso, slope, thick))), 1.0);
}
