// The field at any point, by the table of blocks.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/blocks.glsl"

uniform float u_world_from_stored; // what a stored unit is

// Gradient [world/voxel], index space; zero in blocks that hold no surface.
vec3 field_gradient(vec3 p_local) {
    uint word = word_at(block_of(p_local));
    if (!is_active(word)) return vec3(0.0);
    Block b = fetch_block(int(word & word_number));
    Cell c = cell_of(b.address, b.scale, p_local - (u_table_lo + b.lo));
    return u_world_from_stored * b.scale * tricubic_gradient(c.address, c.a);
}
