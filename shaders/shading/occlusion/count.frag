// Ambient occlusion of composed objects: takes a ray's share from the sky where it meets them.
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(binding = 0) uniform sampler2D t_met;  // what the ray meets: raycast/compose.frag
layout(binding = 1) uniform sampler2D t_seen; // before; drawn over
uniform int u_rays;

out float o_occlusion;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float is_met = texelFetch(t_met, pixel, 0).w != 0.0 ? 1.0 : 0.0;
    o_occlusion = texelFetch(t_seen, pixel, 0).r - is_met / float(u_rays);
}
