// A texture in space, seen where the surface cuts it (thesis section 6.4.2, "Solid texturing").
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/effects/solid_texture.cpp
#version 450 core
#include "common/pixel.glsl"
#include "shading/surface.glsl"
// KIND: raycaster/look.h, SolidTexture::Kind; 4, a volume, with a KERNEL.
#if KIND == 4
#include "filtering/fetches.glsl"
layout(binding = 2) uniform sampler3D t_volume; // samples in texels' middles
#elif KIND == 2 || KIND == 3
#include "shading/solid_texture/noise.glsl"
#elif KIND > 4
#error unknown KIND
#endif

uniform mat3 u_texture_from_world;
uniform vec3 u_offset; // the eye's coordinates: less a multiple of 1024 but for volumes
uniform vec3 u_colour_a;
uniform vec3 u_colour_b;

#if KIND != 4
uniform mat3 u_view_axes; // columns: right, up, back; unit length
uniform vec2 u_pixel;     // its size at the eye, and what it grows by with each unit of depth [world]

// How wide a pixel is along each texture coordinate: a box with the variance of the parallelogram in
// the surface's tangent plane that the pixel covers.
vec3 pixel_width(Surface surface) {
    float size = u_pixel.x - u_pixel.y * dot(surface.point, u_view_axes[2]);
    // 1e-3: seen at so grazing an angle everything is averaged.
    float facing = max(-dot(surface.view, surface.normal), 1e-3);
    vec3 width2 = vec3(0.0);
    for (int i = 0; i < 2; ++i) {
        vec3 step = u_view_axes[i] + surface.view * (dot(u_view_axes[i], surface.normal) / facing);
        vec3 along = u_texture_from_world * step;
        width2 += along * along;
    }
    return size * sqrt(width2);
}
#endif

#if KIND == 0 || KIND == 1
// 1 in the first half of each period and -1 in the second, averaged over a box.
float filtered_square(float t, float width) {
    width = max(width, 1e-4); // rounding stays below a 1000th
    vec2 ends = abs(fract(fract(t) + 0.5 * vec2(-width, width)) - 0.5); // an integral's
    return (ends.x - ends.y) / width;
}
#elif KIND == 3
uniform vec4 u_eye_to_rings; // from the axis to the eye, that distance, its fraction of a ring

// The fraction of t, averaged over a box.
float filtered_saw(float t, float width) {
    width = max(width, 1e-4);
    vec2 ends = fract(t) + 0.5 * vec2(-width, width);
    vec2 rest = fract(ends);
    vec2 integral = 0.5 * (ends - rest + rest * rest);
    return (integral.y - integral.x) / width;
}
#elif KIND == 2
// cos(2 pi t), averaged over a box.
float filtered_cosine(float t, float width) {
    const float pi = 3.14159265358979;
    float a = pi * width;
    return (a < 1e-3 ? 1.0 : sin(a) / a) * cos(2.0 * pi * t);
}
#endif

// Share of the second colour at the texture coordinates that differ from the eye's by d.
float share_of_b(Surface surface, vec3 d) {
    vec3 t = u_offset + d;
#if KIND == 4
    vec3 cell = floor(t);
    vec3 a = t - cell;
    Fetches x = fetches_of_value(a.x);
    Fetches y = fetches_of_value(a.y);
    Fetches z = fetches_of_value(a.z);
    float sum = 0.0;
    for (int k = 0; k < value_fetches; ++k)
        for (int j = 0; j < value_fetches; ++j)
            for (int i = 0; i < value_fetches; ++i)
                sum += x.weight[i] * y.weight[j] * z.weight[k] *
                       textureLod(t_volume, (cell - 0.5 + vec3(x.at[i], y.at[j], z.at[k])) /
                                                vec3(textureSize(t_volume, 0)), 0.0).r;
    return clamp(sum, 0.0, 1.0);
#else
    vec3 width = pixel_width(surface);
#if KIND == 0
    // Exact for a box with its edges along the axes.
    return 0.5 - 0.5 * filtered_square(t.x, width.x) * filtered_square(t.y, width.y) *
                     filtered_square(t.z, width.z);
#elif KIND == 1
    return 0.5 - 0.5 * filtered_square(t.z, width.z);
#elif KIND == 2
    float widest = max(width.x, max(width.y, width.z));
    float veins = 0.0;
    float frequency = 1.0;
    for (int octave = 0; octave < 4; ++octave) {
        veins += visible_share(frequency, widest) / frequency * noise(frequency * t);
        frequency *= 2.0;
    }
    return 0.5 - 0.5 * filtered_cosine(t.z + veins, width.z);
#elif KIND == 3
    float widest = max(width.x, max(width.y, width.z));
    // Stretched along the trunk.
    float warp = visible_share(1.0, widest) * noise(t * vec3(1.0, 1.0, 0.25));
    // The distance from the axis is the eye's plus a difference that does not cancel.
    vec2 to_axis = u_eye_to_rings.xy;
    float difference = dot(2.0 * to_axis + d.xy, d.xy) /
                       max(length(to_axis + d.xy) + u_eye_to_rings.z, 1e-30);
    // A ring darkens slowly and ends at once.
    return filtered_saw(u_eye_to_rings.w + difference + 0.4 * warp, max(width.x, width.y));
#endif
#endif
}

out vec4 o_solid_texture; // linear RGB, coverage

void main() {
    Surface surface = surface_at_pixel();
    o_solid_texture = vec4(0.0);
    // A loop for a condition, as in raycast/derivatives.frag.
    bool is_waiting = surface.object != 0.0;
    while (is_waiting) {
        float share = share_of_b(surface, u_texture_from_world * surface.point);
        o_solid_texture = vec4(mix(u_colour_a, u_colour_b, share), 1.0);
        is_waiting = share < -1e3; // never
    }
}
