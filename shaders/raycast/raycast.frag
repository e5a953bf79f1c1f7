// First hit of each ray with the isosurface: block by block, the nearest first (thesis sections
// 6.3.1-6.3.4).
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/ray.glsl"
#include "raycast/parts.glsl" // here, since a file is included once, also where #if leaves it out
// SEARCH 0: certified steps, 1: samples at a rate.
#if SEARCH == 0
#include "raycast/march.glsl"
#elif SEARCH == 1
#include "raycast/sampled.glsl"
#else
#error unknown SEARCH
#endif
#if IS_STREAMED
#include "raycast/stream.glsl"
#endif

uniform mat3 u_world_from_index;
// The field is defined between these [local index coordinates]; the rays end there.
uniform vec3 u_extent_lo;
uniform vec3 u_extent_hi;

// For each tile of 4 x 4 pixels where its blocks start in t_lists, and how many there are;
// raycaster/tile_lists.h.
layout(binding = 3) uniform isamplerBuffer t_tiles;
layout(binding = 4) uniform isamplerBuffer t_lists;
uniform int u_tile_columns;

out vec4 o_hit; // eye-relative position [world], object (0: none)

// Parameters at which the ray enters and leaves a box. Faces that two boxes share give the same.
vec2 clip_to_box(vec3 point, vec3 inverse, vec3 lo, vec3 hi) {
    vec3 t0 = (lo - point) * inverse;
    vec3 t1 = (hi - point) * inverse;
    vec3 t_in = min(t0, t1);
    vec3 t_out = max(t0, t1);
    return vec2(max(t_in.x, max(t_in.y, t_in.z)), min(t_out.x, min(t_out.y, t_out.z)));
}

void main() {
    o_hit = vec4(0.0);
    Ray ray = pixel_ray(gl_FragCoord.xy);
    vec3 d = ray.direction;
    vec3 inverse = inverse_of(d);
    // Along an axis on which the ray does not move, the middle of its cell stands for its place: in a
    // face between two blocks it is in the upper one alone, all along.
    bvec3 is_still = equal(d, vec3(0.0));
    vec2 range = clip_to_box(mix(ray.point, floor(ray.point) + 0.5, is_still), inverse, u_extent_lo,
                             u_extent_hi);
    range.x = max(range.x, ray.t_start);

    // On which side the ray starts; not known yet if it does in an active block.
    // Rounding must not lead out of the field: beyond its extent the table knows nothing.
    vec3 start = clamp(ray.point + range.x * d, u_extent_lo, u_extent_hi);
    uint word = word_at(block_of(start));
    float side = is_active(word) ? 0.0 : (word & word_inside) != 0u ? -1.0 : 1.0;

    Accuracy accuracy = accuracy_of_frame();
    vec3 point = ray.point - u_table_lo;
    vec3 place = mix(point, floor(point) + 0.5, is_still);
    mat3 world_from_index = u_world_from_index;
    ivec2 tile = ivec2(gl_FragCoord.xy) >> 2;
    ivec2 list = texelFetch(t_tiles, tile.x + u_tile_columns * tile.y).rg;
    int end = range.x < range.y ? list.x + list.y : list.x;
    int i = list.x;
#if IS_STREAMED
    // Progress holds the place in the list, and the side in its two lowest bits.
    int progress = progress_of_pixel();
    if (progress == is_finished) discard;
    if (progress != not_started) {
        i = progress >> 2;
        side = float((progress & 3) - 1);
    }
    bool is_waiting = false;
#endif
    while (i < end) {
        int number = texelFetch(t_lists, i).r;
        Block b = fetch_block(number);
        vec2 segment = clip_to_box(place, inverse, b.lo, b.lo + block_size);
        segment = vec2(max(segment.x, range.x), min(segment.y, range.y));
#if IS_STREAMED
        if (segment.x < segment.y && !visit(number, b.address >= 0)) {
            is_waiting = true;
            break;
        }
#endif
        float s;
        bool is_hit = find_hit(b, accuracy, point, segment.x, d, inverse,
                               segment.y - segment.x, side, s);
        if (is_hit) o_hit = vec4(world_from_index * (ray.from_eye + (segment.x + s) * d), 1.0);
        i = is_hit ? end : i + 1;
    }
#if IS_STREAMED
    set_progress(is_waiting ? i << 2 | int(side) + 1 : is_finished);
    if (is_waiting) discard;
#endif
}
