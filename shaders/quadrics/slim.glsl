// A piece of a SLIM surface on a ray.
// SPDX-License-Identifier: MPL-2.0
// source  Stoll et al. 2006, 5.1.1, eqs 7 and 13: by the roots that do not cancel, about the ray's closest
//         approach to the centre
// twin    quadrics/slim.h: intersect(); quadrics/slim_blend.h
#include "quadrics/quadric.glsl"

// The pieces' hits, from the nearest to the one that surely lies behind.
struct SlimFragment {
    float t; // nowhere if there is none
    vec3 normal;
    bool is_outside; // which is seen
    float weight;
    float reach;    // how far the surface may lie before or behind it, by t
    float gradient; // half its length: 1, by distances
};

// As pieces are written: corner, side | side, number, 0 | centre, radius | a_xx a_xy a_xz b_x |
// a_yy a_yz a_zz 0 | b_y b_z c error | fade, 1 if only what faces the eye shows, planes (3: one of two) |
// plane | plane. f = p^T a p + 2 b^T p + c of p from the centre.
mat3 slim_matrix(vec4 body[7]) {
    return mat3(body[1].xyz, vec3(body[1].y, body[2].xy), vec3(body[1].z, body[2].yz));
}

// 1 at the centre, 0 on the sphere.
float slim_weight(float share) {
    const float inverse_e = 0.36787944;
    return share < 0.5 ? exp(-4.0 * share * share) : 4.0 * inverse_e * (1.0 - share) * (1.0 - share);
}

// Of a level at a depth.
float slim_fade(vec2 slopes, float depth) {
    vec2 share = clamp(depth * slopes - 1.0, 0.0, 1.0);
    return share.x * (1.0 - share.y);
}

// closest  to the centre
SlimFragment slim_fragment(vec4 body[7], vec3 v, ClosestApproach closest, float t_near) {
    mat3 a = slim_matrix(body);
    vec3 b = vec3(body[1].w, body[3].xy);
    vec3 y = closest.y;
    vec3 a_v = a * v;
    vec3 half_gradient_at_y = a * y + b;
    float alpha = dot(v, a_v);
    float beta = dot(v, half_gradient_at_y);
    float gamma = dot(y, half_gradient_at_y + b) + body[3].z;
    float discriminant = beta * beta - alpha * gamma;
    float root = sqrt(max(discriminant, 0.0));
    // f falls along the ray at the first and rises at the second, whatever the sign of alpha.
    vec2 roots = beta < 0.0 ? vec2(gamma, alpha == 0.0 ? 0.0 : root - beta) / vec2(root - beta, alpha)
                            : vec2(beta + root, gamma) / vec2(-alpha, -(beta + root));
    bool is_front_only = body[4].z != 0.0;
    float s = nowhere;
    float share = 1.0;
    for (int i = 0; i < 2; ++i) {
        vec3 p = y + v * roots[i];
        float share_here = length(p) / body[0].w;
        vec2 sides = vec2(dot(body[5].xyz, p) + body[5].w, dot(body[6].xyz, p) + body[6].w);
        float side = body[4].w == 3.0 ? max(sides.x, sides.y) : min(sides.x, sides.y);
        bool is_in = discriminant >= 0.0 && share_here < 1.0 && side >= 0.0 && closest.t + roots[i] >= t_near &&
                     roots[i] < s && !(is_front_only && i == 1);
        s = is_in ? roots[i] : s;
        share = is_in ? share_here : share;
    }
    vec3 half_gradient = half_gradient_at_y + a_v * s;
    float size = length(half_gradient);
    vec3 normal = half_gradient / size;
#if IS_PERSPECTIVE
    float depth = closest.t + s;
#else
    float depth = 1.0;
#endif
    float weight = slim_weight(share) * slim_fade(body[4].xy, depth);
    float facing = -dot(normal, v);
    float slant = max(abs(facing), 0.125 * length(v)); // quadrics/slim_blend.h: least_slant
    bool is_hit = s < nowhere && size > 0.0 && weight > 0.0;
    return SlimFragment(is_hit ? closest.t + s : nowhere, normal, facing >= 0.0, weight, body[3].w / slant, size);
}

SlimFragment slim_fragment(vec4 body[7], vec2 slope, vec3 start, float t_near) {
    return slim_fragment(body, vec3(slope, -1.0), closest_approach_in_view(body[0].xyz - start, slope), t_near);
}

// From a point of the surface, of what is not the sheet that it lies on.
//
// spare  how far the start may be off the finest level
float slim_distance(vec4 body[7], vec3 start, vec3 v, float t_near, float spare) {
    ClosestApproach closest = closest_approach(body[0].xyz - start, v);
    float t = nowhere;
    for (int i = 0; i < 2; ++i) {
        SlimFragment hit = slim_fragment(body, v, closest, t_near);
        // Pieces of the sheet differ by two errors.
        float own = 2.0 * hit.reach + spare * hit.reach / body[3].w;
        t = t == nowhere && hit.t > own ? hit.t : t;
        t_near = own;
    }
    return t;
}
