// How little the isosurface says about a boundary [Kindlmann et al. 2003]: where another iso
// value would turn it, since flow lines are bent, or move it far, since the gradient is weak.
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(binding = 0) uniform sampler2D t_hit;
layout(binding = 1) uniform sampler2D t_gradient;
layout(binding = 2) uniform sampler2D t_flow_line_curvature;
uniform float u_range;            // flow-line curvature of full uncertainty [1/world]
uniform float u_typical_gradient; // [1]
uniform vec3 u_colour;

out vec4 o_uncertainty; // linear RGB, coverage

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (texelFetch(t_hit, pixel, 0).w == 0.0) {
        o_uncertainty = vec4(0.0);
        return;
    }
    float turning = texelFetch(t_flow_line_curvature, pixel, 0).x / u_range;
    // Another iso value moves the surface by 1/|g|: from twice as far as is typical of it.
    float length_g = length(texelFetch(t_gradient, pixel, 0).xyz);
    // 1e-30: no division by zero where most gradients vanish.
    float moving = 1.0 - 2.0 * length_g / max(u_typical_gradient, 1e-30);
    o_uncertainty = vec4(u_colour, clamp(max(turning, moving), 0.0, 1.0));
}
