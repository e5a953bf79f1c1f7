// The back faces of active blocks (thesis section 6.3.2).
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/tile_lists.h: BlockOrder
#version 450 core
#include "raycast/faces.glsl"

layout(binding = 3) uniform isamplerBuffer t_order; // numbers of blocks, the nearest first
uniform vec4 u_eye; // local index coordinates, 1; of parallel rays their direction, turned round, 0

flat out int v_block;

void main() {
    v_block = texelFetch(t_order, gl_VertexID / 36).r;
    int face = gl_VertexID / 6 % 6;
    vec3 lo = fetch_block(v_block).lo;
    int axis = face >> 1;
    bool is_upper = (face & 1) != 0;
    float plane = u_table_lo[axis] + lo[axis] + (is_upper ? block_size : 0.0);
    // Rays leave through the face if the eye is on the block's side of its plane.
    float along = plane * u_eye.w - u_eye[axis];
    bool is_back = is_upper ? along > 0.0 : along < 0.0;
    gl_Position = is_back ? position_of_corner(lo, corner_of_face(face, gl_VertexID % 6))
                          : vec4(2.0, 2.0, 2.0, 1.0); // all corners alike: nothing is drawn
}
