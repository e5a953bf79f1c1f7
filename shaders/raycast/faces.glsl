// Faces of blocks, drawn from nothing but gl_VertexID.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/blocks.glsl"

uniform mat4 u_clip_from_local;
// Drawn faces are wider than blocks by this on each side, times w [voxels]: rasterisers round corners
// to a fraction of a pixel, and a ray must not fall between the picture of a block and the block.
uniform float u_margin;

// Corner 0 ... 5 of the two triangles of a face of a block, as 0 or 1 along each axis.
//
// face  2 axis, plus 1 for the upper one
ivec3 corner_of_face(int face, int vertex) {
    // 0 1 2, 2 1 3
    int corner = vertex < 3 ? vertex : vertex == 3 ? 2 : vertex == 4 ? 1 : 3;
    int axis = face >> 1;
    ivec3 c = ivec3(0);
    c[axis] = face & 1;
    c[(axis + 1) % 3] = corner & 1;
    c[(axis + 2) % 3] = corner >> 1;
    return c;
}

// block_lo  of the block, from the table's corner [voxels]
vec4 position_of_corner(vec3 block_lo, ivec3 corner) {
    vec3 p = u_table_lo + block_lo + block_size * vec3(corner);
    vec4 clip = u_clip_from_local * vec4(p, 1.0);
    return u_clip_from_local * vec4(p + vec3(2 * corner - 1) * (u_margin * max(clip.w, 0.0)), 1.0);
}
