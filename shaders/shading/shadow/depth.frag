// From first hits of the light's rays to the shadow map.
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(binding = 0) uniform sampler2D t_hit; // of the light's camera
uniform vec3 u_depth; // along the light's rays [texels/world]

out float o_depth; // [texels]

const float nowhere = 1e30; // below anything: no hit

void main() {
    vec4 hit = texelFetch(t_hit, ivec2(gl_FragCoord.xy), 0);
    o_depth = hit.w == 0.0 ? nowhere : dot(u_depth, hit.xyz);
}
