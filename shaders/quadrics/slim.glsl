// A piece of a SLIM surface on a ray.
// SPDX-License-Identifier: MPL-2.0
// source  Stoll et al. 2006, 5.1.1, eqs 7 and 13: by the roots that do not cancel, from a place of the ray
//         near the centre
// twin    quadrics/slim.h: intersect(); quadrics/slim_blend.h
#include "quadrics/quadric.glsl"

// FRONT_ONLY: whether of all pieces only what faces the eye shows.
#ifndef FRONT_ONLY
#define FRONT_ONLY 0
#endif

// The piece's hit: of those that its sphere and its planes hold, the nearest.
struct SlimFragment {
    float t;            // nowhere if there is none
    float reach;        // how far the surface may lie before or behind it, by t
    bool is_outside;    // which is seen
    vec3 half_gradient; // of f, half of it, outwards
    float slope;        // its length
    float share2;       // its distance from the centre by the radius, squared
    float fade;         // of its level there
};

// As pieces are written: corner, side | side, number, 0 | centre, radius | a_xx a_xy a_xz b_x |
// a_yy a_yz a_zz 0 | b_y b_z c error | fade, 1 if only what faces the eye shows, planes (3: one of two) |
// plane | plane. f = p^T a p + 2 b^T p + c of p from the centre.
mat3 slim_matrix(vec4 body[7]) {
    return mat3(body[1].xyz, vec3(body[1].y, body[2].xy), vec3(body[1].z, body[2].yz));
}

// 1 at the centre, 0 on the sphere.
float slim_weight(SlimFragment piece) {
    const float inverse_e = 0.36787944;
    float rest = 1.0 - sqrt(piece.share2);
    return piece.fade * (piece.share2 < 0.25 ? exp(-4.0 * piece.share2) : 4.0 * inverse_e * rest * rest);
}

// Of a level at a depth.
float slim_fade(vec2 slopes, float depth) {
    vec2 share = clamp(depth * slopes - 1.0, 0.0, 1.0);
    return share.x * (1.0 - share.y);
}

// near  a place of the ray near the centre, its closest approach or not: for small numbers
SlimFragment slim_fragment(vec4 body[7], vec3 v, ClosestApproach near, float t_near) {
    mat3 a = slim_matrix(body);
    vec3 b = vec3(body[1].w, body[3].xy);
    vec3 y = near.y;
    vec3 a_v = a * v;
    vec3 half_gradient_at_y = a * y + b;
    float alpha = dot(v, a_v);
    float beta = dot(v, half_gradient_at_y);
    float gamma = dot(y, half_gradient_at_y + b) + body[3].z;
    float discriminant = beta * beta - alpha * gamma;
    float root = sqrt(max(discriminant, 0.0));
    // f falls along the ray at the first and rises at the second, whatever the sign of alpha.
    float roots[2] = float[2](beta < 0.0 ? gamma / (root - beta) : (beta + root) / -alpha,
                              beta < 0.0 ? (root - beta) / alpha : gamma / -(beta + root));
    float s = nowhere;
    float distance2 = 0.0; // from the centre
    bool is_outside = true;
    for (int i = 0; i < 2 - FRONT_ONLY; ++i) {
        vec3 p = y + v * roots[i];
        float distance2_here = dot(p, p);
        vec2 sides = vec2(dot(body[5].xyz, p) + body[5].w, dot(body[6].xyz, p) + body[6].w);
        float side = body[4].w == 3.0 ? max(sides.x, sides.y) : min(sides.x, sides.y);
        bool is_in = discriminant >= 0.0 && distance2_here < body[0].w * body[0].w && side >= 0.0 &&
                     near.t + roots[i] >= t_near && roots[i] < s && (i == 0 || body[4].z == 0.0);
        s = is_in ? roots[i] : s;
        distance2 = is_in ? distance2_here : distance2;
        is_outside = is_in ? i == 0 : is_outside;
    }
    vec3 half_gradient = half_gradient_at_y + a_v * s;
    float slope = length(half_gradient);
#if IS_PERSPECTIVE
    float depth = near.t + s;
#else
    float depth = 1.0;
#endif
    float fade = slim_fade(body[4].xy, depth);
    bool is_hit = s < nowhere && slope > 0.0 && fade > 0.0;
    // Half of how steeply f falls or rises along the ray is the root. 1/8: quadrics/slim_blend.h, least_slant.
    float reach = body[3].w * slope / max(root, 0.125 * length(v) * slope);
    return SlimFragment(is_hit ? near.t + s : nowhere, reach, is_outside, half_gradient, slope,
                        distance2 / (body[0].w * body[0].w), fade);
}

// About where the ray is as deep as the centre: not so near as the closest approach, by the cosine with the
// view's axis, but cheaper.
SlimFragment slim_fragment(vec4 body[7], vec2 slope, vec3 start, float t_near) {
    vec3 centre = body[0].xyz - start;
    return slim_fragment(body, vec3(slope, -1.0),
                         ClosestApproach(-centre.z, vec3(-centre.xy - slope * centre.z, 0.0)), t_near);
}

// From a point of the surface, of what is not the sheet that it lies on.
//
// spare  how far the start may be off the finest level
float slim_distance(vec4 body[7], vec3 start, vec3 v, float t_near, float spare) {
    ClosestApproach near = closest_approach(body[0].xyz - start, v);
    float t = nowhere;
    for (int i = 0; i < 2; ++i) {
        SlimFragment hit = slim_fragment(body, v, near, t_near);
        // Pieces of the sheet differ by two errors.
        float own = 2.0 * hit.reach + spare * hit.reach / body[3].w;
        t = t == nowhere && hit.t > own ? hit.t : t;
        t_near = own;
    }
    return t;
}
