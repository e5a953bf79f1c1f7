// The search for a ray's first hit in one block by samples at a rate: what lies between two of them
// is not known (thesis sections 6.3.3 and 6.3.4).
// SPDX-License-Identifier: MPL-2.0
#include "raycast/parts.glsl"
#include "raycast/field.glsl"

// Samples lie at t = k * fine_step, k an integer, whatever the blocks and bricks.
struct Accuracy {
    float fine_step; // 1 / r1 [voxels]
    int per_coarse;  // n: r1 = n r0; a step is n fine ones where |value| is at least `near`
    float near;      // delta [stored units]
};

uniform float u_fine_step;
uniform int u_fine_per_coarse;
uniform float u_near;
uniform int u_refine_steps;

Accuracy accuracy_of_frame() { return Accuracy(u_fine_step, u_fine_per_coarse, u_near); }

// Where a ray that starts at t looks first.
float first_look(float t) { return ceil(t / u_fine_step) * u_fine_step; }

// The root between t_lo, on the ray's side, and t_hi: regula falsi (eq. 6.4) that halves the value of
// an end which stays, and bisection where that leaves the bracket wide.
float refine(vec3 point, vec3 d, float side, float t_lo, float t_hi, float value_hi) {
    float value_lo = -value_hi; // not known: the first guess is the middle
    int stayed = 0;
    for (int i = 0; i < u_refine_steps && t_hi - t_lo > 1e-5; ++i) { // 1e-5 voxel, as of certified hits
        float t = (i & 3) == 3 ? 0.5 * (t_lo + t_hi)
                               : t_lo + (t_hi - t_lo) * (value_lo / (value_lo - value_hi));
        float value = side * field_value(point + t * d, side);
        if (value > 0.0 || value == 0.0 && side > 0.0) {
            t_lo = t;
            value_lo = value;
            value_hi = stayed == 1 ? 0.5 * value_hi : value_hi;
            stayed = 1;
        } else {
            t_hi = t;
            value_hi = value;
            value_lo = stayed == -1 ? 0.5 * value_lo : value_lo;
            stayed = -1;
        }
    }
    return t_lo + (t_hi - t_lo) * (value_lo / (value_lo - value_hi));
}

// The search among the samples of a block, from where the ray enters it, s = 0, to s_out.
struct Search {
    vec3 p_in;  // where it enters, in the block's coordinates
    float t_in; // the ray's parameter there
    float s;    // the next sample; then the root's place, maybe in the block before
    float s_out;
    int k;      // of the next sample
    bool is_on; // there is a sample left
};

Search search_of(Block b, Accuracy accuracy, vec3 point, vec2 segment, vec3 d, vec3 inverse) {
    vec3 p_in = (point - b.lo) + segment.x * d;
    float s_out = segment.y - segment.x;
    int k = int(ceil(segment.x / accuracy.fine_step));
    float s = max(float(k) * accuracy.fine_step - segment.x, 0.0);
    return Search(p_in, segment.x, s, s_out, k, s < s_out);
}

// Looks at one sample. True if the root is found: at s, and the search is over.
//
// point  where t is 0, from the table's corner
// side   on which the ray started: +1 outside, -1 inside, 0 not known yet
bool look(Block b, Accuracy accuracy, vec3 point, vec3 d, vec3 inverse, inout float side,
          inout Search search) {
    int n = accuracy.per_coarse;
    int k = search.k;
    Cell c = cell_of(b.address, b.scale, search.p_in + search.s * d);
    float f = look_at(b, c, d, 0.0, fetch_error(b.slope / b.scale), false).f.x;
    if (side == 0.0) side = f < 0.0 ? -1.0 : 1.0;
    bool is_hit = (f < 0.0) != (side < 0.0);
    if (is_hit) {
        float t = search.t_in + search.s;
        float before = t - float(n) * accuracy.fine_step;
        search.s = refine(point + u_table_lo, d, side, before, t, side * f) - search.t_in;
    } else {
        // To the next sample, fine or coarse; n may not divide k after fine steps.
        search.k = abs(f) < accuracy.near ? k + 1 : (k >= 0 ? k / n + 1 : -((-k - 1) / n)) * n;
        search.s = float(search.k) * accuracy.fine_step - search.t_in;
    }
    search.is_on = !is_hit && search.s < search.s_out;
    return is_hit;
}
