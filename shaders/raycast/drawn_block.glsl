// The block of a fragment: blocks are drawn, those of equal order at a time, the nearest first
// (thesis section 6.3.2).
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/tile_lists.h: BlockOrder
#include "raycast/field.glsl"

layout(binding = 5) uniform sampler2D t_hits; // of the blocks that were drawn before

flat in int v_block;

struct Way {
    int number; // -1: none
};

Way first_block(vec3 place, vec3 d, vec3 inverse, uint start_word, vec3 start, inout float side,
                vec2 range) {
    // Each fragment is on its own, and the block of the ray's first look may not be its block.
    if (side == 0.0) {
        vec3 p_local = start + (first_look(range.x) - range.x) * d;
        float side_of_block = (word_at(block_of(p_local)) & word_inside) != 0u ? -1.0 : 1.0;
        side = field_value(p_local, side_of_block) < 0.0 ? -1.0 : 1.0;
    }
    bool is_open = range.x < range.y && texelFetch(t_hits, ivec2(gl_FragCoord.xy), 0).w == 0.0;
    return Way(is_open ? v_block : -1);
}

bool has_block(Way way) { return way.number >= 0; }

int number_of(Way way) { return way.number; }

Way next_block(Way way, bool is_hit, vec3 place, vec3 d, vec3 inverse) { return Way(-1); }
