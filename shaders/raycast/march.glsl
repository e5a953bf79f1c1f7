// The search for a ray's first hit in one block, by steps that provably pass no surface.
// SPDX-License-Identifier: MPL-2.0
// proof  docs/raycasting.md
#include "raycast/parts.glsl"

// 1e-5: hits are located to this along the ray [voxels]; float coordinates of 100 voxels are
// 4e-6 apart.
const float tolerance = 1e-5;

// The first point from s on, s_out at most, that lies in a part which can hold the surface.
//
// p_in  where the ray enters the block, in its coordinates; s runs from there [voxels]
float next_part(vec3 p_in, vec3 d, vec3 inverse, uvec2 parts, float s, float s_out) {
    ivec3 part = clamp(ivec3(floor(0.5 * (p_in + s * d))), ivec3(0), ivec3(3));
    uint bits = part.z < 2 ? parts.x : parts.y;
    bool is_empty = (bits >> (part.x + 4 * part.y + 16 * (part.z & 1)) & 1u) == 0u;
    bool is_seeking = is_empty && s < s_out;
    while (is_seeking) {
        bvec3 is_up = greaterThanEqual(inverse, vec3(0.0));
        vec3 exits = (2.0 * vec3(mix(part, part + 1, is_up)) - p_in) * inverse;
        // Out of the block the ray goes at s_out, whatever rounding makes of it.
        exits = mix(exits, vec3(s_out), equal(part, mix(ivec3(0), ivec3(3), is_up)));
        float first_exit = min(exits.x, min(exits.y, exits.z));
        s = max(s, first_exit);
        // In whole numbers along the axis of the exit, so that the walk cannot stall.
        ivec3 forward = mix(ivec3(-1), ivec3(1), is_up);
        if (exits.x == first_exit)
            part.x += forward.x;
        else if (exits.y == first_exit)
            part.y += forward.y;
        else
            part.z += forward.z;
        bool has_left = any(notEqual(part & 3, part));
        s = has_left ? s_out : s;
        bits = part.z < 2 ? parts.x : parts.y;
        is_empty = (bits >> (part.x + 4 * part.y + 16 * (part.z & 1)) & 1u) == 0u;
        is_seeking = is_empty && s < s_out;
    }
    return min(s, s_out);
}

// How far from a point there is no root: no nearer than where the steepest line or the parabola that
// bends most comes down to zero. The bend is known in near cells only: a ray that leaves them climbs
// to `near` and falls from there; from afar it falls alone.
//
// value  at least 0: less its own error
float safe_step(Block b, float value, float slope) {
    float speed = abs(slope);
    float q = sqrt(slope * slope + 2.0 * b.bend * value) + speed;
    float second = slope <= 0.0 ? 2.0 * value / (q + 1e-30) : q * b.inverse_bend; // 1e-30: not 0 / 0
    float first = value * b.inverse_slope;
    float detour = (2.0 * b.near - value) * b.inverse_slope;
    second = second < detour ? second : detour;
    return value < b.near && second > first ? second : first;
}

// What a search keeps to. Uniforms are read once, before any loop: some compilers read them anew in
// every pass.
struct Accuracy {
    float guarantee;   // longest stretch inside the object that a ray may pass [voxels]
    float value_error; // of an evaluated value [stored units]
};

uniform float u_guarantee;
uniform float u_value_error;

Accuracy accuracy_of_frame() { return Accuracy(u_guarantee, u_value_error); }

// Where a ray that starts at t looks first.
float first_look(float t) { return t; }

// The search for the first root in a block, from where the ray enters it, s = 0, to s_out.
struct Search {
    vec3 p_in;  // where it enters, in the block's coordinates
    float t_in; // the ray's parameter there
    float s;    // where to look next; then the root's place
    float s_out;
    float lo;   // the last point known to lie before the surface; then the bracket of its root
    float hi;
    bool is_bracketed;
    int tries;
    bool is_on; // there is something to look at
};

Search search_of(Block b, Accuracy accuracy, vec3 point, vec2 segment, vec3 d, vec3 inverse) {
    vec3 p_in = (point - b.lo) + segment.x * d;
    float s_out = segment.y - segment.x;
    float s = next_part(p_in, d, inverse, b.parts, 0.0, s_out);
    return Search(p_in, segment.x, s, s_out, s, s, false, 0, s < s_out);
}

// Looks once. True if the root is found: at s, and the search is over.
//
// point  where t is 0, from the table's corner
// side   on which the ray started: +1 outside, -1 inside, 0 not known yet
bool look(Block b, Accuracy accuracy, vec3 point, vec3 d, vec3 inverse, inout float side,
          inout Search search) {
    float s = search.s;
    Cell c = cell_of(b.address, b.scale, search.p_in + s * d);
    Look seen = look_at(b, c, d, accuracy.value_error, fetch_error(b.slope / b.scale),
                        search.is_bracketed);
    vec2 f = seen.f;
    if (side == 0.0) side = f.x < 0.0 ? -1.0 : 1.0;
    // Values times `side` are positive before the surface.
    bool has_crossed = (f.x < 0.0) != (side < 0.0);
    float value = side * f.x;
    float slope = side * f.y;
    bool is_hit = false;
    if (search.is_bracketed) {
        search.hi = has_crossed ? s : search.hi;
        search.lo = has_crossed ? search.lo : s;
    } else {
        float sure = value - seen.value_error;
        float safe = safe_step(b, sure > 0.0 ? sure : 0.0, slope - seen.slope_error);
        // A root before `latest` for sure, and only one, if the opposite parabola falls.
        float above = value + seen.value_error;
        // Twice `above` is near: the parabola may rise from there before it falls, not as high.
        float flatter = slope + seen.slope_error;
        float fall = flatter * flatter - 2.0 * b.bend * above;
        float latest = s + 2.0 * above / (sqrt(fall > 0.0 ? fall : 0.0) - flatter);
        bool is_near = 2.0 * above < b.near && flatter < 0.0 && fall > 0.0 && latest <= search.s_out;
        search.is_bracketed = has_crossed || is_near;
        search.hi = has_crossed ? s : latest;
        search.lo = has_crossed ? search.lo : s;
        if (!search.is_bracketed) {
            // A step by the guarantee alone may pass a root: it ends with a look, at the latest
            // where the ray leaves the block; else what comes next would find the ray inside,
            // and take the place where it starts for the root's.
            bool is_sure = safe >= accuracy.guarantee;
            float next = s + (is_sure ? safe : accuracy.guarantee);
            search.is_on = !is_sure && s < search.s_out;
            search.s = is_sure ? next_part(search.p_in, d, inverse, b.parts, next, search.s_out)
                               : min(next, search.s_out);
            search.is_on = search.is_on || search.s < search.s_out;
        }
    }
    if (search.is_bracketed) {
        // Newton's step where it stays in the bracket, else its middle.
        float newton = -value / slope;
        float next = s + newton;
        ++search.tries;
        bool is_newton =
            slope < 0.0 && next >= search.lo && next <= search.hi && search.tries < 8;
        next = is_newton ? next : 0.5 * (search.lo + search.hi);
        // Newton's error: half the bend times the step squared, over the slope.
        float bent = -0.5 * b.bend * newton * newton / slope;
        float error = bent < abs(newton) ? bent : abs(newton);
        search.s = next;
        is_hit = seen.is_final && is_newton && error <= tolerance || search.hi - search.lo <= tolerance;
        search.is_on = !is_hit;
    }
    return is_hit;
}
