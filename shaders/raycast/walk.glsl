// The blocks of a ray: those that it meets on a walk of the table.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/block_table.h

#if TRAVERSAL == 2
// Between the outermost faces of active blocks that a pixel sees: least t, least -t (thesis section
// 6.3.1).
layout(binding = 5) uniform sampler2D t_bounds;
#endif

struct Way {
    ivec3 block; // in the table
    uint word;
    float t;     // where the ray enters the block, about
    float t_end;
};

bool has_block(Way way) { return way.t < way.t_end; }

int number_of(Way way) { return int(way.word & word_number); }

// From block to block until one is active or the ray ends.
Way walk(Way way, bool is_leaving, vec3 place, vec3 d, vec3 inverse) {
    ivec3 blocks = page_blocks * u_table_pages;
    bvec3 is_up = greaterThanEqual(inverse, vec3(0.0));
    bool is_walking = is_leaving || !is_active(way.word) && has_block(way);
    while (is_walking) {
        // The empty cube that the ray crosses; the block alone if it is active.
#if TRAVERSAL == 3
        int reach = is_active(way.word) ? 1 : int(way.word & word_number);
        int shift = !is_active(way.word) && (way.word & word_of_page) != 0u ? 2 : 0;
        ivec3 at = way.block >> shift;
        ivec3 lo = (at - reach + 1) << shift;
        ivec3 hi = (at + reach) << shift;
#else
        ivec3 lo = way.block;
        ivec3 hi = way.block + 1;
#endif
        vec3 exits = (block_size * vec3(mix(lo, hi, is_up)) - place) * inverse;
        float first_exit = min(exits.x, min(exits.y, exits.z));
        way.t = max(way.t, first_exit);
        // Never backwards, whatever rounding makes of it, so that the walk cannot stall.
        ivec3 next = clamp(ivec3(floor((place + way.t * d) / block_size)), lo, hi - 1);
        next = mix(min(next, way.block), max(next, way.block), is_up);
        ivec3 beyond = mix(lo - 1, hi, is_up);
        if (exits.x == first_exit)
            next.x = beyond.x;
        else if (exits.y == first_exit)
            next.y = beyond.y;
        else
            next.z = beyond.z;
        way.block = next;
        bool has_left = any(lessThan(next, ivec3(0))) || any(greaterThanEqual(next, blocks));
        way.t = has_left ? way.t_end : way.t;
        way.word = has_left ? 0u : word_at(next);
        is_walking = !is_active(way.word) && has_block(way);
    }
    return way;
}

Way first_block(vec3 place, vec3 d, vec3 inverse, uint start_word, vec3 start, inout float side,
                vec2 range) {
#if TRAVERSAL == 2
    vec2 bounds = texelFetch(t_bounds, ivec2(gl_FragCoord.xy), 0).rg;
    // From an active block the ray starts without a face.
    vec2 active_range = vec2(is_active(start_word) ? range.x : bounds.x, -bounds.y);
#else
    vec2 active_range = clip_to_box(place, inverse, vec3(0.0),
                                    block_size * vec3(page_blocks * u_table_pages));
#endif
    float t = max(range.x, active_range.x);
    ivec3 block = clamp(ivec3(floor((place + t * d) / block_size)), ivec3(0),
                        page_blocks * u_table_pages - 1);
    Way way = Way(block, word_at(block), t, min(range.y, active_range.y));
    return walk(way, false, place, d, inverse);
}

Way next_block(Way way, bool is_hit, vec3 place, vec3 d, vec3 inverse) {
    way.t = is_hit ? way.t_end : way.t;
    return walk(way, !is_hit, place, d, inverse);
}
