// The GL's own points, to compare splats with.
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(binding = 0) uniform samplerBuffer t_centres; // [pixels]
uniform vec2 u_clip_from_pixel;
uniform float u_point_pixels;

void main() {
    gl_Position = vec4(texelFetch(t_centres, gl_VertexID).xy * u_clip_from_pixel - 1.0, 0.0, 1.0);
    gl_PointSize = u_point_pixels;
}
