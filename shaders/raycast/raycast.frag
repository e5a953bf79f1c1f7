// First hit of each ray with the isosurface: block by block, the nearest first (thesis sections
// 6.3.1-6.3.4).
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/scene.h: Traversal
#version 450 core
#include "common/ray.glsl"
// Here, since a file is included once, also where #if leaves it out.
#include "raycast/field.glsl"
#include "raycast/parts.glsl"
// SEARCH 0: certified steps, 1: samples at a rate.
#if SEARCH == 0
#include "raycast/march.glsl"
#elif SEARCH == 1
#include "raycast/sampled.glsl"
#else
#error unknown SEARCH
#endif
// Which blocks a ray looks at. TRAVERSAL 0: those of its tile's list; 1: that of the fragment, whose
// back faces are drawn; 2: those between the faces around the active ones, one after the other;
// 3: those that a walk of the table meets, with jumps over empty space.
#if TRAVERSAL == 0
#include "raycast/lists.glsl"
#elif TRAVERSAL == 1
#include "raycast/drawn_block.glsl"
#elif TRAVERSAL == 2 || TRAVERSAL == 3
#include "raycast/walk.glsl"
#else
#error unknown TRAVERSAL
#endif
#if IS_STREAMED
#include "raycast/stream.glsl"
#endif
#if COUNTS_STEPS
// The looks at the field that a ray's searches have taken so far.
layout(binding = 1, r32f) uniform image2D i_steps;
#endif

uniform mat3 u_world_from_index;
// The field is defined between these [local index coordinates]; the rays end there.
uniform vec3 u_extent_lo;
uniform vec3 u_extent_hi;

#if IS_TO_SKY
// Operands: the rays are those of ambient occlusion, not the camera's.
#include "shading/occlusion/sky.glsl"
uniform int u_ray; // of each pixel
uniform mat3 u_index_from_world;
uniform vec3 u_eye_local;
uniform float u_lift_world; // of the rays' starts off the surface
#endif
#if IS_OPERAND
// An object of several, searched from its last root on (compose.frag).
layout(binding = 5) uniform sampler2D t_root;    // that root; 0 before the first search
layout(binding = 6) uniform sampler2D t_pending; // whether to search, by bits
uniform int u_operand;
#if !IS_TO_SKY
uniform float u_near_share; // of the way from `point` back to the ray's start, where distances count from
#endif
uniform vec2 u_restart;     // how far behind a root the search goes on [voxels] [world]
const float no_root = 1e30;
#endif

// With IS_OPERAND w is the distance [world], negative if the ray is inside before the root.
layout(location = 0) out vec4 o_hit; // eye-relative position [world], object (0: none)
#if HAS_GRADIENT
// What raycast/derivatives.frag would find: here the hit's block is known, and reading hits again is
// saved.
layout(location = 1) out vec4 o_gradient;
uniform mat3 u_index_from_world;
uniform vec3 u_eye_local;
uniform float u_world_from_stored;
#endif

void main() {
    o_hit = vec4(0.0);
#if IS_TO_SKY
    Sky sky = sky_of_pixel(u_lift_world, 0.0);
    vec3 way_of_ray = u_index_from_world * way_to_sky(sky, u_ray);
    float voxels = length(way_of_ray); // of a world unit
    Ray ray = Ray(u_eye_local + u_index_from_world * sky.start, way_of_ray / voxels, vec3(0.0), 0.0);
#else
    Ray ray = pixel_ray();
#endif
    vec3 d = ray.direction;
    vec3 inverse = inverse_of(d);
    // Along an axis on which the ray does not move, the middle of its cell stands for its place: in a
    // face between two blocks it is in the upper one alone, all along.
    bvec3 is_still = equal(d, vec3(0.0));
    vec2 range = clip_to_box(mix(ray.point, floor(ray.point) + 0.5, is_still), inverse, u_extent_lo,
                             u_extent_hi);
    range.x = max(range.x, ray.t_start);
#if IS_TO_SKY
    range.y = sky.is_there ? min(range.y, u_distance_world * voxels) : range.x;
#endif
#if IS_OPERAND
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    bool is_pending = (int(texelFetch(t_pending, pixel, 0).r) >> u_operand & 1) != 0;
    float last = texelFetch(t_root, pixel, 0).w;
    float world_from_t = length(u_world_from_index * d);
#if IS_TO_SKY
    float t_near = 0.0;
#else
    float t_near = u_near_share * ray.t_start;
#endif
    if (last != 0.0)
        range.x = max(range.x, (abs(last) + u_restart.y) / world_from_t + t_near + u_restart.x);
    range.y = is_pending ? range.y : range.x;
#endif

    // On which side the ray starts; not known yet if it does in an active block.
    // Rounding must not lead out of the field: beyond its extent the table knows nothing.
    vec3 start = clamp(ray.point + range.x * d, u_extent_lo, u_extent_hi);
    uint word = word_at(block_of(start));
    float side = is_active(word) ? 0.0 : (word & word_inside) != 0u ? -1.0 : 1.0;
#if IS_OPERAND
    // The side is told even if there is no root, and behind a root it is the other one. Where the
    // field has come back by then, this is the next root. Beyond the table's faces the side is
    // theirs.
    vec3 in_table = clamp(start, u_table_lo,
                          u_table_lo + block_size * vec3(page_blocks * u_table_pages));
    bool is_in_extent = range.x < range.y;
    float seen = side == 0.0 ? 1.0 : side;
    bool is_unknown = is_in_extent && side == 0.0;
    while (is_unknown) { // a loop for a condition: see derivatives.frag
        seen = field_value(in_table, seen);
        is_unknown = seen > no_root; // never
    }
    bool has_side = seen < 0.0 && is_in_extent;
    side = last != 0.0 ? -sign(last) : has_side ? -1.0 : 1.0;
    bool is_root_at_start = is_in_extent && (seen < 0.0) != (side < 0.0);
    float t_root_found = is_root_at_start ? range.x : no_root;
    range.y = is_root_at_start ? range.x : range.y;
#endif

    Accuracy accuracy = accuracy_of_frame();
    vec3 point = ray.point - u_table_lo;
    vec3 place = mix(point, floor(point) + 0.5, is_still);
    mat3 world_from_index = u_world_from_index;
    Way way = first_block(place, d, inverse, word, start, side, range);
#if IS_STREAMED
    // Progress holds the place in the list, and the side in its two lowest bits.
    int progress = progress_of_pixel();
    if (progress == is_finished) discard;
    if (progress != not_started) {
        way.i = progress >> 2;
        side = float((progress & 3) - 1);
    }
    bool is_waiting = false;
#endif
    // One loop for all blocks of a ray: a look, and on to the next block where this one is done, so
    // that rays side by side look at a time, though they are in different blocks.
    Block b;
    Search search;
    bool is_seeking = has_block(way);
    bool is_marching = is_seeking;
#if COUNTS_STEPS
    float steps = 0.0;
#endif
    while (is_marching) {
        while (is_seeking) {
            int number = number_of(way);
            b = fetch_block(number);
            vec2 segment = clip_to_box(place, inverse, b.lo, b.lo + block_size);
            segment = vec2(max(segment.x, range.x), min(segment.y, range.y));
#if IS_STREAMED
            is_waiting = segment.x < segment.y && !visit(number, b.address >= 0);
            if (is_waiting) break;
#endif
            search = search_of(b, accuracy, point, segment, d, inverse);
            if (!search.is_on) way = next_block(way, false, place, d, inverse);
            is_seeking = !search.is_on && has_block(way);
        }
#if IS_STREAMED
        if (is_waiting) break;
#endif
        if (search.is_on) {
            bool is_hit = look(b, accuracy, point, d, inverse, side, search);
#if COUNTS_STEPS
            steps += 1.0;
#endif
            float t = search.t_in + search.s;
            if (is_hit) o_hit = vec4(world_from_index * (ray.from_eye + t * d), 1.0);
#if IS_OPERAND
            t_root_found = is_hit ? t : t_root_found;
#endif
            is_seeking = !search.is_on && !is_hit;
            if (is_seeking) way = next_block(way, false, place, d, inverse);
            is_seeking = is_seeking && has_block(way);
        }
        is_marching = search.is_on || is_seeking;
    }
#if COUNTS_STEPS
    ivec2 counter = ivec2(gl_FragCoord.xy);
    imageStore(i_steps, counter, imageLoad(i_steps, counter) + steps);
#endif
#if IS_OPERAND
    // 1e-30: even at the eye it has a sign.
    bool is_found = t_root_found < no_root;
    float distance = is_found ? max(world_from_t * (t_root_found - t_near), 1e-30) : no_root;
    if (is_root_at_start) o_hit.xyz = world_from_index * (ray.from_eye + t_root_found * d);
    o_hit.w = side * distance;
    if (!is_pending) discard;
#endif
#if HAS_GRADIENT
    o_gradient = vec4(0.0);
    bool is_to_do = o_hit.w != 0.0;
    while (is_to_do) { // a loop for a condition: see derivatives.frag
        vec3 p_local = u_eye_local + u_index_from_world * o_hit.xyz;
        Cell c = cell_of(b.address, b.scale, p_local - (u_table_lo + b.lo));
        vec3 gradient_index = u_world_from_stored * (b.scale * tricubic_gradient(c.address, c.a));
        o_gradient = vec4(transpose(u_index_from_world) * gradient_index, 1.0);
        is_to_do = b.scale < 0.0; // never
    }
#endif
#if IS_STREAMED
    set_progress(is_waiting ? way.i << 2 | int(side) + 1 : is_finished);
    if (is_waiting) discard;
#endif
#if TRAVERSAL == 1
    if (o_hit.w == 0.0) discard;
#endif
}
