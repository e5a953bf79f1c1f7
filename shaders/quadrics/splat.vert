// A rectangle of pixels for each splat, as two triangles of four vertices (raycaster/splats_on_gpu.h), or a
// triangle around it. No vertex attributes: drawn as instances, software rasterisers shade four vertices at a
// time.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
// KIND: quadrics/splats.h, SplatKind; FLOATS4: of a splat, by four; PLACE4: of its place;
// VERTICES: 4 for two triangles, 3 for one.

layout(binding = 0) uniform samplerBuffer t_records; // of this kind
uniform vec2 u_clip_from_pixel;                      // 2 / size of the part, per axis
#if OUTPUT == 0
uniform int u_first_slot;
#endif
// With a number in a free place: of the splat + 1, or of its colour.
flat out vec4 v_splat[FLOATS4 - PLACE4];
#if OUTPUT >= 2
flat out float v_triangle; // its number
#endif
#if OUTPUT == 3
layout(binding = 4) uniform samplerBuffer t_colours; // by primitive
flat out vec3 v_colour;
#if KIND == 2
uniform int u_to_half_colours; // from that of a stick to that of its half at b, if any has two
flat out vec3 v_colour_b;
#endif
#endif

void main() {
    int splat = gl_VertexID / VERTICES;
    int corner = gl_VertexID % VERTICES; // x0y0, x1y0, x0y1, x1y1
    vec2 side = vec2(corner & 1, corner >> 1);
    vec4 first = texelFetch(t_records, FLOATS4 * splat);
    vec2 side_a = KIND == 0 ? vec2(first.z, 0.0) : first.zw;
    vec2 side_b = KIND == 0 ? vec2(0.0, first.w) : texelFetch(t_records, FLOATS4 * splat + 1).xy;
    for (int i = PLACE4; i < FLOATS4; ++i) v_splat[i - PLACE4] = texelFetch(t_records, FLOATS4 * splat + i);
#if OUTPUT == 0
    float number = float(u_first_slot + splat + 1);
#elif OUTPUT >= 2
    vec4 second = texelFetch(t_records, FLOATS4 * splat + 1);
    float number = KIND == 0 ? second.y : second.z;
    v_triangle = second.w;
#endif
#if OUTPUT != 1
#if KIND == 0
    v_splat[0].y = number;
#else
    v_splat[2].w = number;
#endif
#endif
#if OUTPUT == 3
    v_colour = texelFetch(t_colours, int(number)).rgb;
#if KIND == 2
    v_colour_b = texelFetch(t_colours, int(number) + u_to_half_colours).rgb;
#endif
#endif
    vec2 pixel = first.xy + side.x * side_a + side.y * side_b;
    gl_Position = vec4(pixel * u_clip_from_pixel - 1.0, 0.0, 1.0);
}
