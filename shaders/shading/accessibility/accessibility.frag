// Black where a ball does not fit into a concave place (thesis section 6.4.2 and figure 6.11).
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(binding = 0) uniform sampler2D t_curvature;
uniform float u_radius; // of the smallest ball that does not fit [world]

out vec4 o_accessibility; // black, coverage

void main() {
    vec4 curvature = texelFetch(t_curvature, ivec2(gl_FragCoord.xy), 0);
    // 0 where there is no hit or no gradient, for curvatures are 0 there.
    o_accessibility = vec4(vec3(0.0), clamp(-curvature.y * u_radius, 0.0, 1.0));
}
