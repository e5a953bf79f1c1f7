// Both principal curvatures through a picture (thesis section 6.4.2, "Curvature color mapping").
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(binding = 0) uniform sampler2D t_curvature;
layout(binding = 1) uniform sampler2D t_map; // from corner to corner: -u_range to u_range
uniform float u_range;                       // [1/world]

out vec4 o_curvature_map; // linear RGB; the map's coverage, 0 where the gradient vanishes

void main() {
    vec4 curvature = texelFetch(t_curvature, ivec2(gl_FragCoord.xy), 0);
    vec4 colour = textureLod(t_map, 0.5 + 0.5 * curvature.xy / u_range, 0.0);
    o_curvature_map = curvature.w != 0.0 && curvature.w != 2.0 ? colour : vec4(0.0);
}
