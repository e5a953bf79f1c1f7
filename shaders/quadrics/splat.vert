// A rectangle of pixels for each splat, as a strip of two triangles.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
// KIND: quadrics/splats.h, SplatKind; FLOATS4: of a splat, by four.

layout(location = 0) in vec4 a_splat[FLOATS4];
uniform vec2 u_clip_from_pixel; // 2 / size of the part, per axis
uniform int u_first_slot;

flat out vec4 v_splat[FLOATS4 - 1]; // without the first four floats
flat out float v_slot;              // number of the splat + 1

void main() {
    vec2 side = vec2(gl_VertexID & 1, gl_VertexID >> 1);
#if KIND == 0
    vec2 pixel = a_splat[0].xy + side * a_splat[0].zw;
#else
    vec2 pixel = a_splat[0].xy + side.x * a_splat[0].zw + side.y * a_splat[1].xy;
#endif
    for (int i = 1; i < FLOATS4; ++i) v_splat[i - 1] = a_splat[i];
    v_slot = float(u_first_slot + gl_InstanceID + 1);
    gl_Position = vec4(pixel * u_clip_from_pixel - 1.0, 0.0, 1.0);
}
