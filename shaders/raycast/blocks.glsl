// Which blocks are active, and where their samples are: two levels, pages of 4^3 blocks of 8^3
// cells (thesis section 6.2).
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/block_table.cpp
#include "filtering/tricubic.glsl"

const float block_size = 8.0; // volume/sparse_field.h
const int page_blocks = 4;    // raycaster/block_table.h

// One word for each page of the table, then 64 for each page that has active blocks.
layout(binding = 0) uniform usamplerBuffer t_table;
// Two texels for each active block: (slope, bend, near, scale), (address, parts, place in the table:
// 11 bits of x, 11 of y, 10 of z).
layout(binding = 2) uniform usamplerBuffer t_blocks;
uniform ivec3 u_table_pages;  // extent of the table
uniform vec3 u_table_lo;      // its low corner [local index coordinates]

// Words. Of a page with active blocks: its number; of an active block: its number; of an empty
// page or block: how far the cube of empty pages or blocks around it reaches, itself included.
const uint word_active = 0x80000000u;
const uint word_inside = 0x40000000u; // the field is negative there
const uint word_of_page = 0x20000000u;
const uint word_number = 0x1fffffffu;

bool is_active(uint word) { return word >= word_active; }

// The word of the block (block coordinates in the table).
uint word_at(ivec3 block) {
    ivec3 page = block >> 2;
    uint word = texelFetch(t_table, page.x + u_table_pages.x * (page.y + u_table_pages.y * page.z)).r;
    if (is_active(word)) {
        ivec3 b = block & 3;
        word = texelFetch(t_table, int(word & word_number) + b.x + 4 * b.y + 16 * b.z).r;
    }
    return word;
}

// The block of a point, in the table even where rounding or an eye outside would leave it: beyond
// the table's faces the field does not change its sign.
ivec3 block_of(vec3 p_local) {
    return clamp(ivec3(floor((p_local - u_table_lo) / block_size)), ivec3(0),
                 page_blocks * u_table_pages - 1);
}

// An active block: where its samples are, and what certifies steps through it
// (filtering/certificate.h).
struct Block {
    vec3 lo;     // low corner, from the table's [voxels]
    int address; // of the sample below its first one, along each axis
    float scale; // stored cells per voxel: 1, 1/2, ... in bricks of lower resolution
    float slope; // greatest |gradient| [1/voxel]
    float bend;  // greatest second derivative [1/voxel^2] in the cells that hold a value
    float near;  // closer to iso than this, all in stored units
    uvec2 parts; // bits of the 2^3 parts that can hold the surface
    float inverse_slope;
    float inverse_bend;
};

Block fetch_block(int number) {
    vec4 bounds = uintBitsToFloat(texelFetch(t_blocks, 2 * number));
    uvec4 place = texelFetch(t_blocks, 2 * number + 1);
    vec3 block = vec3(uvec3(place.w, place.w >> 11, place.w >> 22) & uvec3(2047u, 2047u, 1023u));
    return Block(block_size * block, int(place.x), bounds.w, bounds.x, bounds.y,
                 bounds.z, place.yz, 1.0 / max(bounds.x, 1e-30), 1.0 / max(bounds.y, 1e-30));
}

// The cell of a point of a block, and where the point lies in it. The point may lie outside by
// rounding: the polynomial piece of the outermost cell goes on.
struct Cell {
    int address;
    vec3 a;
};

Cell cell_of(int address, float scale, vec3 p_block) {
    vec3 p = scale * p_block;
    vec3 cell = clamp(floor(p), vec3(0.0), vec3(scale * block_size - 1.0));
    ivec3 c = ivec3(cell);
    return Cell(address + c.x + c.y * ROW_STRIDE + c.z * PLANE_STRIDE, p - cell);
}
