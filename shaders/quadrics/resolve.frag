// Hits of splats, where no field is hit before.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "quadrics/splats.glsl"
// GRADIENT_AT, COLOUR_AT: where these are written, -1 for nowhere.

layout(binding = 0) uniform sampler2D t_hit; // of the fields; written here
uniform float u_object; // as whose hits they are written
#if COLOUR_AT >= 0
layout(binding = 4) uniform samplerBuffer t_colours; // by primitive
#endif

layout(location = 0) out vec4 o_hit;
#if GRADIENT_AT >= 0
layout(location = GRADIENT_AT) out vec4 o_gradient;
#endif
#if COLOUR_AT >= 0
layout(location = COLOUR_AT) out vec4 o_colour;
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    int slot = int(texelFetch(t_splat, pixel, 0).r) - 1;
    Seen seen = seen_splat(slot);
    // Another program met it first, whose roundings may differ.
    if (slot < 0 || seen.hit.t >= nowhere) discard;
    vec3 p = ray_start() + vec3(ray_slope(), -1.0) * seen.hit.t;
    vec3 p_world = u_world_from_view * p;
#if HAS_FIELDS
    vec4 other = texelFetch(t_hit, pixel, 0);
    // Both lie on one ray.
    vec3 back = u_world_from_view[2];
    if (other.w != 0.0 && dot(back, other.xyz) >= p.z) discard;
#endif
    o_hit = vec4(p_world, u_object);
#if GRADIENT_AT >= 0
    o_gradient = vec4(u_world_from_view * seen.hit.normal, width_on_picture(seen));
#endif
#if COLOUR_AT >= 0
    o_colour = vec4(texelFetch(t_colours, seen.colour).rgb, 1.0);
#endif
}
