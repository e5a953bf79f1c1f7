// Where a ray first meets a superquadric, the unit ball of a norm N, and how that bends there.
// SPDX-License-Identifier: MPL-2.0
// source  Kindlmann 2004 for the body; Newton's method on a convex function
// twin    quadrics/superquadric_norm.h, quadrics/ray_superquadric.h, which say more and prove it

// N(q) = (M^r + |q_z|^r)^(1/r) with M = (|q_x|^p + |q_y|^p)^(1/p), in q = local_from_view (point - centre).
struct Superquadric {
    vec3 centre; // from the ray's start, view space
    mat3 local_from_view;
    float p, r;
};

// As splats are written: corner, side | side, number, 0 | centre, p | three rows of local_from_view,
// with r in the first.
Superquadric superquadric_of(vec4 centre, vec4 row0, vec4 row1, vec4 row2, vec3 start) {
    return Superquadric(centre.xyz - start, transpose(mat3(row0.xyz, row1.xyz, row2.xyz)), centre.w,
                        row0.w);
}

// (|a|^e + |b|^e)^(1/e) of a, b >= 0, and its derivatives by them.
vec3 pair_norm(float a, float b, float e) {
    float greater = max(a, b);
    float lesser = min(a, b);
    float u = greater > 0.0 ? lesser / greater : 0.0;
    float u_e = u > 0.0 ? pow(u, e) : 0.0;
    float sum = 1.0 + u_e;
    float root = pow(sum, 1.0 / e);
    float by_greater = root / sum;
    float by_lesser = u > 0.0 ? by_greater * (u_e / u) : 0.0;
    return vec3(greater * root, a >= b ? vec2(by_greater, by_lesser) : vec2(by_lesser, by_greater));
}

// The gradient of N, then N.
vec4 superquadric_norm(vec3 q, Superquadric body) {
    vec3 m = pair_norm(abs(q.x), abs(q.y), body.p);
    vec3 n = pair_norm(m.x, abs(q.z), body.r);
    vec3 size = vec3(n.y * m.yz, n.z);
    return vec4(mix(size, -size, lessThan(q, vec3(0.0))), n.x);
}

// The least s in [from, to] with N(base + s k) <= 1, where N >= 1 at `from`; `nowhere` if there is none.
float first_crossing(Superquadric body, vec3 base, vec3 k, float from, float to) {
    // 2^-20: 8 roundings.
    const float surface_tolerance = exp2(-20.0);
    float s = from;
    float crossing = nowhere;
    // As many steps as floats have digits; it is passed by the one that ends the search.
    for (int step = 0; step < 24; ++step) {
        vec4 n = superquadric_norm(base + k * s, body);
        float excess = n.w - 1.0;
        float slope = dot(n.xyz, k);
        bool is_there = excess <= surface_tolerance;
        crossing = is_there ? s : nowhere;
        s -= excess / slope;
        // A tangent that does not fall, or falls to 0 behind the end: no root, for certain.
        if (is_there || !(slope < 0.0) || !(s <= to)) break;
    }
    return crossing;
}

// The first point along the ray of direction v, at t >= t_near.
QuadricHit superquadric_hit(Superquadric body, vec3 v, ClosestApproach closest, float t_near) {
    // From the point of the ray that is closest to the centre, by local distance.
    vec3 k = body.local_from_view * v;
    vec3 p = body.local_from_view * closest.y;
    float shift = -dot(p, k) / dot(k, k);
    p += k * shift;
    float t_base = closest.t + shift;
    vec2 cube = vec2(-nowhere, nowhere);
    for (int axis = 0; axis < 3; ++axis) {
        vec2 slab = within_slab(p[axis], k[axis]);
        cube = vec2(max(cube.x, slab.x), min(cube.y, slab.y));
    }
    // Where the way in lies behind the start, the way out is the way in of the ray from the other side.
    float s = nowhere;
    for (float side = cube.x <= cube.y ? 1.0 : 0.0; side != 0.0;) {
        float crossing = side > 0.0 ? first_crossing(body, p, k, cube.x, cube.y)
                                    : -first_crossing(body, p, -k, -cube.y, -cube.x);
        bool is_behind = t_base + crossing < t_near;
        s = abs(crossing) < nowhere && !is_behind ? crossing : nowhere;
        side = side > 0.0 && is_behind ? -1.0 : 0.0;
    }
    vec3 q = p + k * s;
    vec3 gradient = superquadric_norm(q, body).xyz;
    return QuadricHit(s < nowhere ? t_base + s : nowhere,
                      normalize(transpose(body.local_from_view) * gradient), q, false);
}

QuadricHit superquadric_hit(Superquadric body, vec2 slope, float t_near) {
    return superquadric_hit(body, vec3(slope, -1.0), closest_approach_in_view(body.centre, slope), t_near);
}

// Of caps, as depth_inside_quadric().
float depth_inside_superquadric(Superquadric body, vec3 v, float t) {
#if CUT_PLANES > 0 && CUT_LOOK == 2
    return superquadric_norm(body.local_from_view * (v * t - body.centre), body).w - 1.0;
#else
    return 0.0;
#endif
}
float depth_inside_superquadric(Superquadric body, vec2 slope, float t) {
    return depth_inside_superquadric(body, vec3(slope, -1.0), t);
}

// Of N at q with N(q) = 1.
mat3 superquadric_norm_hessian(vec3 q, Superquadric body) {
    vec3 size = abs(q);
    float m = pair_norm(size.x, size.y, body.p).x;
    float n = pair_norm(m, size.z, body.r).x;
    // x, y by m; m, z by n; and their powers, where 0^0 is 1.
    vec4 ratio = vec4(m > 0.0 ? size.xy / m : vec2(1.0, 0.0), m / n, size.z / n);
    vec4 exponent = vec4(body.p, body.p, body.r, body.r) - 2.0;
    vec4 power = mix(pow(ratio, exponent), vec4(0.0), equal(ratio, vec4(0.0)));
    power = mix(power, vec4(1.0), equal(exponent, vec4(0.0)));
    float x = ratio.x, y = ratio.y, u = ratio.z, v = ratio.w;
    float x2 = power.x, y2 = power.y, u2 = power.z, v2 = power.w;
    vec2 m_xy = vec2(x2 * x, y2 * y);
    float bend_m = (body.p - 1.0) * x2 * y2;
    float bend_n = (body.r - 1.0) * u2 * v2;
    float n_mm = bend_n * v * v;
    float n_mz = -bend_n * u * v;
    float h_xx = n_mm * m_xy.x * m_xy.x + u2 * bend_m * y * y;
    float h_yy = n_mm * m_xy.y * m_xy.y + u2 * bend_m * x * x;
    float h_xy = n_mm * m_xy.x * m_xy.y - u2 * bend_m * x * y;
    vec2 h_z = n_mz * m_xy;
    vec3 side = mix(vec3(1.0), vec3(-1.0), lessThan(q, vec3(0.0)));
    mat3 h = mat3(h_xx, h_xy, h_z.x, h_xy, h_yy, h_z.y, h_z, bend_n * u * u);
    return matrixCompMult(h, outerProduct(side, side)) / n;
}
