// What searches of a block and traversals share.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/blocks.glsl"

// What a search sees at a point [stored units, voxels], and how wrong it may be.
struct Look {
    vec2 f; // value and slope
    float value_error;
    float slope_error;
    bool is_final; // as exact as can be
};

// Where the error of linear fetches leaves the side open, and all along a refinement, the exact sum is
// taken.
//
// value_error  of the exact sum
// fetch_error  of the block
Look look_at(Block b, Cell c, vec3 d, float value_error, float fetch_error, bool is_refining) {
#if FETCH == 2
    vec2 f = vec2(0.0);
#if IS_REFINED_EXACTLY
    if (!is_refining) f = fast_value_and_slope(c.address, c.a, b.scale * d);
    bool is_exact = abs(f.x) <= value_error + fetch_error;
    if (is_exact) f = tricubic_value_and_slope(c.address, c.a, b.scale * d);
    float more = is_exact ? 0.0 : fetch_error;
    return Look(f, value_error + more, 4.0 * value_error + 8.0 * more, is_exact);
#else
    f = fast_value_and_slope(c.address, c.a, b.scale * d);
    return Look(f, value_error + fetch_error, 4.0 * value_error + 8.0 * fetch_error, true);
#endif
#else
    // The slope may err by four times as much [1/voxel]: the sums of |weights| are 2 and 1.
    return Look(tricubic_value_and_slope(c.address, c.a, b.scale * d), value_error,
                4.0 * value_error, true);
#endif
}

// 1 / direction; a zero component counts as a tiny positive one: its planes are never reached.
vec3 inverse_of(vec3 direction) {
    return 1.0 / mix(direction, vec3(1e-30), equal(direction, vec3(0.0))); // 1e-30: 1/x is finite
}

// Parameters at which the ray enters and leaves a box. Faces that two boxes share give the same.
vec2 clip_to_box(vec3 point, vec3 inverse, vec3 lo, vec3 hi) {
    vec3 t0 = (lo - point) * inverse;
    vec3 t1 = (hi - point) * inverse;
    vec3 t_in = min(t0, t1);
    vec3 t_out = max(t0, t1);
    return vec2(max(t_in.x, max(t_in.y, t_in.z)), min(t_out.x, min(t_out.y, t_out.z)));
}
