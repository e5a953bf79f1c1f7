// The first hit of a ray with the zero set of a quadratic function in a tetrahedron.
// SPDX-License-Identifier: MPL-2.0
// source  Stoll, Gumhold, Seidel 2007, section 5.1.2; but not by planes and the quadric's equation: by
//         barycentric coordinates where the ray enters and leaves, and the function's polar form of the two.
//         A face's values are the same floats from both sides, so that one of two neighbours is always hit.
// twin    quadrics/tetrahedra.h: intersect(), by planes
#include "quadrics/bernstein.glsl"
#include "quadrics/quadric.glsl"

// l^T C l of barycentric coordinates l: Bernstein-Bezier coefficients.
struct QuadraticForm {
    vec4 c0, c1, c2, c3; // columns of C
};

QuadraticForm quadratic_form(float c00, vec4 more, vec4 others, float c33) {
    return QuadraticForm(vec4(c00, more.xyz), vec4(more.x, more.w, others.xy), vec4(more.y, others.x, others.zw),
                         vec4(more.z, others.y, others.w, c33));
}

// Summed in one order: what is 0 adds nothing, wherever among the corners it is.
vec4 half_derivatives(QuadraticForm form, vec4 l) {
    precise vec4 sum = form.c0 * l.x;
    sum = sum + form.c1 * l.y;
    sum = sum + form.c2 * l.z;
    sum = sum + form.c3 * l.w;
    return sum;
}
float in_order(vec4 a, vec4 b) {
    precise float sum = a.x * b.x;
    sum = sum + a.y * b.y;
    sum = sum + a.z * b.z;
    sum = sum + a.w * b.w;
    return sum;
}

// The part of a ray's line in a tetrahedron.
struct Chord {
    vec4 l_in, l_out; // barycentric coordinates
    float t_in, t_out;
};

// w  volumes that the ray spans with the edges 01 02 03 12 13 23; 0 within their roundings
// t  of the corners, along the ray
Chord chord_of(float w[6], vec4 t) {
    vec4 of_faces[4] = vec4[4](vec4(0.0, w[5], -w[4], w[3]), vec4(w[5], 0.0, -w[2], w[1]),
                               vec4(w[4], -w[2], 0.0, w[0]), vec4(w[3], -w[1], w[0], 0.0));
    Chord chord = Chord(vec4(0.0), vec4(0.0), nowhere, -nowhere);
    for (int face = 0; face < 4; ++face) {
        vec4 l = of_faces[face];
        bool is_crossed = all(greaterThanEqual(l, vec4(0.0))) || all(lessThanEqual(l, vec4(0.0)));
        l /= in_order(l, vec4(1.0));
        float at = in_order(l, t); // NaN of a face that is seen edge-on: others are crossed
        if (is_crossed && at < chord.t_in) {
            chord.l_in = l;
            chord.t_in = at;
        }
        if (is_crossed && at >= chord.t_out) { // or as far, as floats tell: a sliver has a function, too
            chord.l_out = l;
            chord.t_out = at;
        }
    }
    return chord;
}

struct TetrahedronHit {
    float t;
    vec4 l;
};

TetrahedronHit tetrahedron_hit_on(Chord chord, QuadraticForm form, float t_near) {
    vec4 by_in = half_derivatives(form, chord.l_in);
    vec4 by_out = half_derivatives(form, chord.l_out);
    vec4 roots = bernstein_roots(in_order(chord.l_in, by_in), in_order(chord.l_in, by_out),
                                 in_order(chord.l_out, by_out));
    TetrahedronHit first = TetrahedronHit(nowhere, vec4(0.0));
    for (int i = 0; i < 2; ++i) {
        vec2 share = i == 0 ? roots.xy : roots.zw;
        bool is_in = min(share.x, share.y) >= 0.0 || max(share.x, share.y) <= 0.0;
        share /= share.x + share.y;
        float t = chord.t_in * share.y + chord.t_out * share.x;
        if (is_in && chord.t_in < nowhere && t >= t_near && t < first.t)
            first = TetrahedronHit(t, chord.l_in * share.y + chord.l_out * share.x);
    }
    return first;
}

// As tetrahedra are written: corner, side | side, number, 0 | edge 01, depth 0 | 02, 1 | 03 | 12, 2 | 13, 3 |
// 23, c00 | c01 c02 c03 c11 | c12 c13 c22 c23 | gradients of l1, c33 | l2 | l3.
QuadraticForm form_of(vec4 body[11]) {
    return quadratic_form(body[5].w, body[6], body[7], body[8].w);
}

// With the barycentric coordinates of corners 1, 2, 3 in q.
//
// at  the ray's slope, of parallel rays its start
QuadricHit tetrahedron_hit(vec4 body[11], vec2 at, float t_near) {
    vec3 ray = vec3(at, -1.0);
    float w[6];
    for (int i = 0; i < 6; ++i) {
        float volume = dot(body[i].xyz, ray);
        // 2^-22: as of triangles.
        w[i] = abs(volume) <= exp2(-22.0) * dot(abs(body[i].xyz), abs(ray)) ? 0.0 : volume;
    }
    Chord chord = chord_of(w, vec4(body[0].w, body[1].w, body[3].w, body[4].w));
    QuadraticForm form = form_of(body);
    TetrahedronHit hit = tetrahedron_hit_on(chord, form, t_near);
    vec4 half_slopes = half_derivatives(form, hit.l);
    half_slopes -= half_slopes.x;
    vec3 gradient = body[8].xyz * half_slopes.y + body[9].xyz * half_slopes.z + body[10].xyz * half_slopes.w;
    gradient = gradient == vec3(0.0) ? vec3(0.0, 0.0, 1.0) : gradient;
    return QuadricHit(hit.t > 0.0 ? hit.t : nowhere, normalize(gradient), hit.l.yzw, false);
}

// By the length of the gradient.
mat3 tetrahedron_hessian(vec4 body[11], QuadricHit hit) {
    QuadraticForm form = form_of(body);
    mat3 gradients = mat3(body[8].xyz, body[9].xyz, body[10].xyz);
    vec4 half_slopes = half_derivatives(form, vec4(1.0 - hit.q.x - hit.q.y - hit.q.z, hit.q));
    float size = length(gradients * (half_slopes.yzw - half_slopes.x));
    // C in differences from the first corner.
    mat3 c = mat3(form.c1.yzw, form.c2.yzw, form.c3.yzw);
    vec3 first = form.c0.yzw;
    for (int k = 0; k < 3; ++k) c[k] += form.c0.x - first[k] - first;
    return size > 0.0 ? gradients * c * transpose(gradients) / size : mat3(0.0);
}

// From anywhere, of a body in quadrics/tree.glsl: corner, c | for each | c01 c02 c03 c12 | c13 c23.
float tetrahedron_distance(vec4 body[6], vec3 start, vec3 v, float t_near) {
    float w[6];
    vec4 t;
    int edge = 0;
    for (int k = 0; k < 4; ++k) {
        vec3 a = body[k].xyz - start;
        t[k] = dot(a, v) / dot(v, v);
        for (int l = k + 1; l < 4; ++l) {
            vec3 side = body[l].xyz - body[k].xyz;
            float volume = dot(v, cross(a, side));
            // 2^-21: eight roundings, of differences, a cross product and a dot product, by the lengths.
            w[edge++] = abs(volume) <= exp2(-21.0) * length(a) * length(side) * length(v) ? 0.0 : volume;
        }
    }
    QuadraticForm form = quadratic_form(body[0].w, vec4(body[4].xyz, body[1].w),
                                        vec4(body[4].w, body[5].x, body[2].w, body[5].y), body[3].w);
    return tetrahedron_hit_on(chord_of(w, t), form, t_near).t;
}
