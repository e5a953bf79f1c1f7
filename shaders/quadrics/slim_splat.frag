// Blended hits of SLIM surfaces, among other splats by depth.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "quadrics/slim_blend.glsl"
#include "common/octahedral.glsl"

// OUTPUT: raycaster/splat_passes.h, SplatOutput.
layout(binding = 15) uniform sampler2D t_nearest;
layout(binding = 1) uniform sampler2D t_slim;
uniform float u_depth_unit; // as in quadrics/splat.frag
#if OUTPUT == 0
uniform float u_to_slot; // from the number of a colour
layout(location = 0) out float o_splat;
#else
layout(location = 0) out uvec2 o_surface;
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 nearest = texelFetch(t_nearest, pixel, 0).xy;
    vec4 hit = slim_hit(nearest, texelFetch(t_slim, pixel, 0));
    if (hit.w >= nowhere) discard;
    gl_FragDepth = u_depth_unit / hit.w;
    float number = abs(nearest.y); // of its colour + 1
#if OUTPUT == 0
    o_splat = number + u_to_slot;
#else
    o_surface = uvec2(uint(number), packed_direction(hit.xyz));
#endif
}
