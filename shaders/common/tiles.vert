// The tiles of the picture in which there can be something, in runs along x: two triangles for each
// run, no vertex attributes.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/tile_lists.cpp
#version 450 core

layout(binding = 31) uniform isamplerBuffer t_runs; // x of the first tile and past the last, y, 0
uniform vec2 u_clip_from_tile;                     // 2 tile / picture size, per axis

void main() {
    ivec4 run = texelFetch(t_runs, gl_VertexID / 6);
    // 0 1 2, 2 1 3: corners x0y0, x1y0, x0y1, x1y1.
    int corner = gl_VertexID % 6;
    corner = corner < 3 ? corner : corner == 3 ? 2 : corner == 4 ? 1 : 3;
    vec2 tile = vec2((corner & 1) == 0 ? run.x : run.y, run.z + (corner >> 1));
    gl_Position = vec4(tile * u_clip_from_tile - 1.0, 0.0, 1.0);
}
