// The blocks of a ray: those of its tile's list.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/tile_lists.h

// For each tile of 4 x 4 pixels where its blocks start in t_lists, and how many there are.
layout(binding = 3) uniform isamplerBuffer t_tiles;
layout(binding = 4) uniform isamplerBuffer t_lists;
uniform int u_tile_columns;

struct Way {
    int i; // in t_lists
    int end;
};

Way first_block(vec3 place, vec3 d, vec3 inverse, uint start_word, vec3 start, inout float side,
                vec2 range) {
    ivec2 tile = ivec2(gl_FragCoord.xy) >> 2;
    ivec2 list = texelFetch(t_tiles, tile.x + u_tile_columns * tile.y).rg;
    return Way(list.x, range.x < range.y ? list.x + list.y : list.x);
}

bool has_block(Way way) { return way.i < way.end; }

int number_of(Way way) { return texelFetch(t_lists, way.i).r; }

Way next_block(Way way, bool is_hit, vec3 place, vec3 d, vec3 inverse) {
    way.i = is_hit ? way.end : way.i + 1;
    return way;
}
