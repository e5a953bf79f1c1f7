// Ambient occlusion of scenes with several things: takes a ray's share from the sky where it meets one.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
// HAS_PRIMITIVES: besides what the fields' rays meet.
#if HAS_PRIMITIVES
#include "shading/occlusion/sky.glsl"
#include "quadrics/tree.glsl"
uniform int u_ray;
#else
uniform int u_rays;
#endif

layout(binding = 0) uniform sampler2D t_met;  // what the ray meets: raycast/compose.frag
layout(binding = 1) uniform sampler2D t_seen; // before; drawn over

out float o_occlusion;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    bool is_met = texelFetch(t_met, pixel, 0).w != 0.0;
#if HAS_PRIMITIVES
    Sky sky = sky_of_pixel(0.0, lift_share);
    float reach = sky.is_there && !is_met ? u_distance_world : -1.0;
    is_met = is_met || meets_any(sky.start, way_to_sky(sky, u_ray), reach);
#endif
    o_occlusion = texelFetch(t_seen, pixel, 0).r - (is_met ? 1.0 : 0.0) / float(u_rays);
}
