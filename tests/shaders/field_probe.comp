// Evaluates the production field functions at given points.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "raycast/field.glsl"

uniform float u_world_from_stored;

struct Probe {
    vec4 p_local;
    vec4 direction;
};
struct Result {
    vec4 value_and_slope; // stored units, along the direction; z 1 in an active block, else all 0
    vec4 gradient;        // world units
    vec4 fast;            // the same by the fewest fetches, in a block; its fetch_error()
    vec4 fast_gradient;
};

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Probes { Probe probes[]; };
layout(std430, binding = 1) writeonly buffer Results { Result results[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= probes.length()) return;
    vec3 p_local = probes[i].p_local.xyz;
    results[i] = Result(vec4(0.0), vec4(u_world_from_stored * field_gradient(p_local), 0.0),
                        vec4(0.0), vec4(0.0));
    uint word = word_at(block_of(p_local));
    if (!is_active(word)) return;
    Block b = fetch_block(int(word & word_number));
    Cell c = cell_of(b.address, b.scale, p_local - (u_table_lo + b.lo));
    vec2 f = tricubic_value_and_slope(c.address, c.a, b.scale * probes[i].direction.xyz);
    results[i].value_and_slope = vec4(f, 1.0, 0.0);
    results[i].fast = vec4(fast_value_and_slope(c.address, c.a, b.scale * probes[i].direction.xyz),
                           fetch_error(b.slope / b.scale), 0.0);
    results[i].fast_gradient =
        vec4(u_world_from_stored * b.scale * fast_gradient(c.address, c.a), 0.0);
}
