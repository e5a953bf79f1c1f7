// The field at any point, by the table of blocks.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/blocks.glsl"

// Value minus iso [stored units]; in blocks that hold no surface, something on the side of `side`.
float field_value(vec3 p_local, float side) {
    uint word = word_at(block_of(p_local));
    float value = side;
    bool is_stored = is_active(word);
    while (is_stored) {
        Block b = fetch_block(int(word & word_number));
        Cell c = cell_of(b.address, b.scale, p_local - (u_table_lo + b.lo));
        value = tricubic_value_and_slope(c.address, c.a, vec3(0.0)).x;
        is_stored = b.scale < 0.0; // never
    }
    return value;
}

// Gradient [stored units/voxel], index space; zero in blocks that hold no surface.
vec3 field_gradient(vec3 p_local) {
    uint word = word_at(block_of(p_local));
    if (!is_active(word)) return vec3(0.0);
    Block b = fetch_block(int(word & word_number));
    Cell c = cell_of(b.address, b.scale, p_local - (u_table_lo + b.lo));
#if FETCH == 2
#if !IS_REFINED_EXACTLY
    return b.scale * fast_gradient(c.address, c.a);
#endif
#endif
    return b.scale * tricubic_gradient(c.address, c.a);
}

// Gradient and Hessian [stored units/voxel, /voxel^2], index space; zero in blocks that hold no
// surface.
Derivatives field_derivatives(vec3 p_local) {
    uint word = word_at(block_of(p_local));
    if (!is_active(word)) return Derivatives(vec3(0.0), mat3(0.0), 0.0);
    Block b = fetch_block(int(word & word_number));
    Cell c = cell_of(b.address, b.scale, p_local - (u_table_lo + b.lo));
    Derivatives f = tricubic_derivatives(c.address, c.a);
    return Derivatives(b.scale * f.gradient, b.scale * b.scale * f.hessian, f.greatest);
}
