// Whether a ray enters or leaves the composed solid at the nearest roots of the objects, or passes
// them.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/csg.h: InsideTable
#version 450 core

// OBJECTS: how many.
layout(binding = 8) uniform sampler2D t_roots[OBJECTS]; // raycast.frag: o_hit with IS_OPERAND
layout(binding = 6) uniform sampler2D t_pending;        // objects to be searched on, by bits
uniform int u_inside[(1 << OBJECTS) + 31 >> 5]; // for each set of objects whether it is inside
uniform float u_errors[OBJECTS]; // of distances; roots may be at one place if these overlap [world]

// For each tile of 4 x 4 pixels the objects that some of its pixels wait for, by bits.
layout(std430, binding = 0) buffer Waiting { uint waiting[]; };
uniform int u_tile_columns;

layout(location = 0) out vec4 o_hit; // eye-relative position [world], object (0: none)
layout(location = 1) out float o_pending;

const float no_root = 1e30; // of raycast.frag

// set  of objects, by bits
bool is_inside(int set) { return (u_inside[set >> 5] >> (set & 31) & 1) != 0; }

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    bool is_open = texelFetch(t_pending, pixel, 0).r != 0.0;
    float distances[OBJECTS];
    float first = no_root;
    float first_end = no_root; // with its error
    int set = 0;    // of objects that the ray is in before the roots
    int coming = 0; // of those that have roots
    for (int i = 0; i < OBJECTS; ++i) {
        float w = texelFetch(t_roots[i], pixel, 0).w;
        distances[i] = abs(w);
        set |= w < 0.0 ? 1 << i : 0;
        coming |= distances[i] < no_root ? 1 << i : 0;
        first_end = distances[i] < first ? distances[i] + u_errors[i] : first_end;
        first = min(first, distances[i]);
    }
    // What is passed at the nearest root, one object after the other, the nearest first: at a place
    // that two objects share, the ray may enter the one and leave the other.
    bool was_inside = is_inside(set);
    bool is_in = was_inside;
    int owner = -1; // at whose root the solid begins or ends
    bool is_taken_away = false;
    int passed = 0;
    for (int i = 0; i < OBJECTS; ++i) {
        int next = -1;
        float nearest = no_root;
        for (int k = 0; k < OBJECTS; ++k) {
            bool is_nearer = (passed >> k & 1) == 0 && distances[k] < nearest &&
                             distances[k] - u_errors[k] <= first_end;
            next = is_nearer ? k : next;
            nearest = is_nearer ? distances[k] : nearest;
        }
        int bit = next < 0 ? 0 : 1 << next;
        bool is_in_object = (set & bit) != 0;
        set ^= bit;
        passed |= bit;
        bool is_in_now = is_inside(set);
        if (is_in_now != is_in) {
            owner = next;
            is_taken_away = is_in_object != is_in;
        }
        is_in = is_in_now;
    }
    bool is_hit = is_in != was_inside;
    // Whether the roots that can still come can make a difference.
    bool can_change = false;
    for (int other = 0; other < 1 << OBJECTS; ++other)
        can_change = can_change ||
                     (other & ~coming) == (set & ~coming) && is_inside(other) != was_inside;
    int pending = is_open && !is_hit && can_change ? passed : 0;

    o_hit = vec4(0.0);
    for (int i = 0; i < OBJECTS; ++i)
        if (is_hit && i == owner)
            o_hit = vec4(texelFetch(t_roots[i], pixel, 0).xyz, is_taken_away ? -i - 1 : i + 1);
    if (pending != 0)
        atomicOr(waiting[(pixel.x >> 2) + u_tile_columns * (pixel.y >> 2)], uint(pending));
    o_pending = float(pending);
    if (!is_open) discard;
}
