// Ambient occlusion: the share of a sky of even light that is seen, by rays through the field.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "raycast/march.glsl"
#include "raycast/walk.glsl"
#include "shading/occlusion/sky.glsl"

uniform vec3 u_extent_lo;
uniform vec3 u_extent_hi;
uniform mat3 u_index_from_world;
uniform vec3 u_eye_local;
uniform float u_lift_world; // of the rays' starts off the surface

out float o_occlusion;

// Whether a ray from outside the object meets it: certified, as the picture's rays.
//
// point  from the table's corner [voxels]
// d      of unit length in index space
// side   of the surface on which the ray starts
bool is_blocked(vec3 point, vec3 d, float t_end, float side, Accuracy accuracy) {
    vec3 inverse = inverse_of(d);
    vec3 place = mix(point, floor(point) + 0.5, equal(d, vec3(0.0))); // as in raycast.frag
    vec2 range = clip_to_box(place, inverse, u_extent_lo - u_table_lo, u_extent_hi - u_table_lo);
    range = vec2(0.0, min(range.y, t_end));
    Way way = first_block(place, d, inverse, 0u, point, side, range);
    Block b;
    Search search;
    bool is_hit = false;
    bool is_seeking = has_block(way);
    bool is_marching = is_seeking;
    while (is_marching) {
        while (is_seeking) {
            b = fetch_block(number_of(way));
            vec2 segment = clip_to_box(place, inverse, b.lo, b.lo + block_size);
            segment = vec2(max(segment.x, range.x), min(segment.y, range.y));
            search = search_of(b, accuracy, point, segment, d, inverse);
            if (!search.is_on) way = next_block(way, false, place, d, inverse);
            is_seeking = !search.is_on && has_block(way);
        }
        if (search.is_on) {
            look(b, accuracy, point, d, inverse, side, search);
            is_hit = search.is_bracketed; // there is a root; where does not matter
            is_seeking = !search.is_on && !is_hit;
            if (is_seeking) way = next_block(way, false, place, d, inverse);
            is_seeking = is_seeking && has_block(way);
        }
        is_marching = !is_hit && (search.is_on || is_seeking);
    }
    return is_hit;
}

void main() {
    Sky sky = sky_of_pixel(u_lift_world, 0.0);
    vec3 start = u_eye_local + u_index_from_world * sky.start;
    Accuracy accuracy = accuracy_of_frame();
    // Where the gradient vanishes there is no sky to look at.
    int count = sky.is_there ? u_rays : 0;
    int blocked = 0;
    for (int i = 0; i < count; ++i) {
        vec3 way = u_index_from_world * way_to_sky(sky, i); // [voxels], for a world unit
        float voxels = length(way);
        if (is_blocked(start - u_table_lo, way / voxels, u_distance_world * voxels, sky.side, accuracy))
            ++blocked;
    }
    o_occlusion = 1.0 - float(blocked) / float(u_rays);
}
