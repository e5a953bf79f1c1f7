// The faces between active blocks and others (thesis section 6.3.1).
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/block_table.h: bounding_faces
#version 450 core
#include "raycast/faces.glsl"

layout(binding = 3) uniform isamplerBuffer t_faces; // block, face

flat out int v_axis;
flat out float v_plane; // from the table's corner [voxels]

void main() {
    ivec2 face = texelFetch(t_faces, gl_VertexID / 6).rg;
    vec3 lo = fetch_block(face.x).lo;
    ivec3 corner = corner_of_face(face.y, gl_VertexID % 6);
    v_axis = face.y >> 1;
    v_plane = lo[v_axis] + ((face.y & 1) != 0 ? block_size : 0.0);
    gl_Position = position_of_corner(lo, corner);
}
