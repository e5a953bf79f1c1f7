// Where a ray first meets a quadric.
// SPDX-License-Identifier: MPL-2.0
// source  Sigg et al. 2006 eqs 6, 7 and 9, along the ray; the discriminant at the closest approach
//         to the centre and the stable roots as in Ray Tracing Gems ch. 7
// twin    quadrics/ray_quadric.h, which says more

// f(q) in local coordinates q, by kind; inside is negative.
const int ball = 0;    // |q|^2 - 1
const int cone = 1;    // q_x^2 + q_y^2 - r(q_z)^2 where |q_z| <= 1, r(z) = middle + slope z
const int general = 2; // q^T a q + 2 b^T q + c where |q_x|, |q_y|, |q_z| <= 1

struct Quadric {
    vec3 centre;          // from the ray's start, view space
    mat3 local_from_view; // q = local_from_view (p - centre)
    float radius_middle, radius_slope;
    bvec2 has_cap;
    mat3 a;
    vec3 b;
    float c;
    float value_at_start; // f there
    bool is_near;         // the start is so close that roots are counted from it
};

struct QuadricHit {
    float t;     // in lengths of the direction; `nowhere` if there is none
    vec3 normal; // view space, unit length, outwards; against the ray at a cone's apex
    vec3 q;      // local coordinates
    bool is_cap;
};

const float nowhere = 1e30;

// f along a ray: alpha s^2 + 2 beta s + gamma.
struct Quadratic {
    float alpha, beta, gamma;
};

Quadratic along_ray(int kind, Quadric quadric, vec3 p, vec3 k) {
    if (kind == ball) return Quadratic(dot(k, k), dot(k, p), dot(p, p) - 1.0);
    if (kind == cone) {
        // A difference of squares as a product, so that it keeps its digits along the sides.
        float r = quadric.radius_middle + quadric.radius_slope * p.z;
        float k_r = quadric.radius_slope * k.z;
        float k_xy = length(k.xy);
        float p_xy = length(p.xy);
        return Quadratic((k_xy - k_r) * (k_xy + k_r), dot(k.xy, p.xy) - k_r * r,
                         (p_xy - r) * (p_xy + r));
    }
    vec3 a_p = quadric.a * p;
    return Quadratic(dot(k, quadric.a * k), dot(k, a_p + quadric.b),
                     dot(p, a_p + 2.0 * quadric.b) + quadric.c);
}

vec3 half_gradient(int kind, Quadric quadric, vec3 q) {
    if (kind == ball) return q;
    if (kind == cone)
        return vec3(q.xy, -quadric.radius_slope * (quadric.radius_middle + quadric.radius_slope * q.z));
    return quadric.a * q + quadric.b;
}

// Half of the Hessian of f, in local coordinates.
mat3 half_hessian(int kind, Quadric quadric) {
    if (kind == ball) return mat3(1.0);
    if (kind == cone)
        return mat3(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -quadric.radius_slope * quadric.radius_slope);
    return quadric.a;
}

// The lesser root first. Where alpha is 0 one of them is infinite: no interval holds it.
// discriminant  beta^2 - alpha gamma >= 0
vec2 stable_roots(Quadratic f, float discriminant) {
    float root = sqrt(discriminant);
    float q = -(f.beta + (f.beta < 0.0 ? -root : root)); // no sign(): that of 0 must not be 0
    float s1 = f.gamma / q;
    float s2 = q / f.alpha;
    return s1 <= s2 ? vec2(s1, s2) : vec2(s2, s1);
}

// The part of the ray p + s k where |q_i| <= 1; empty if x > y.
vec2 within_slab(float p, float k) {
    if (k == 0.0) return abs(p) <= 1.0 ? vec2(-nowhere, nowhere) : vec2(nowhere, -nowhere);
    float s1 = (-1.0 - p) / k;
    float s2 = (1.0 - p) / k;
    return vec2(min(s1, s2), max(s1, s2));
}

// Where a ray comes closest to a centre.
struct ClosestApproach {
    float t;
    vec3 y; // from the centre
};

// Of the direction (slope, -1). Nothing as long as the distance is taken from anything: y errs by a
// rounding of the centre's distance from the view's axis, however far it is away.
ClosestApproach closest_approach_in_view(vec3 centre, vec2 slope) {
    vec2 w = centre.xy + slope * centre.z;
    float back = dot(slope, w) / (1.0 + dot(slope, slope));
    return ClosestApproach(back - centre.z, vec3(slope * back - w, -back));
}

ClosestApproach closest_approach(vec3 centre, vec3 v) {
    float t = dot(v, centre) / dot(v, v);
    return ClosestApproach(t, v * t - centre);
}

// The first point along the ray of direction v, at t >= t_near.
QuadricHit first_hit(int kind, Quadric quadric, vec3 v, ClosestApproach closest, float t_near) {
    // To the point of the ray that is closest to the centre, by its distance and then by local.
    vec3 k = quadric.local_from_view * v;
    vec3 p = quadric.local_from_view * closest.y;
    float shift = -dot(p, k) / dot(k, k);
    p += k * shift;
    Quadratic f = along_ray(kind, quadric, p, k);
    // Then to where f is extreme, unless that is farther from the centre than the clip (sqrt(3)).
    if (kind != ball) {
        bool is_shifted = abs(f.beta) * length(k) < 2.0 * abs(f.alpha);
        float to_extremum = is_shifted ? -f.beta / f.alpha : 0.0;
        p += k * to_extremum;
        shift += to_extremum;
        f = along_ray(kind, quadric, p, k);
    }
    float discriminant = f.beta * f.beta - f.alpha * f.gamma;
    // From near by, roots are counted from the start: the other way would swallow the distance to a surface
    // right in front.
    float t_base = closest.t + shift;
    if (quadric.is_near) {
        t_base = 0.0;
        p = -(quadric.local_from_view * quadric.centre);
        f = along_ray(kind, quadric, p, k);
        f.gamma = quadric.value_at_start;
    }
    bool has_roots = discriminant >= 0.0;
    vec2 roots = stable_roots(f, max(discriminant, 0.0));

    vec2 clip = vec2(-nowhere, nowhere);
    if (kind != ball) {
        for (int axis = kind == cone ? 2 : 0; axis < 3; ++axis) {
            vec2 slab = within_slab(p[axis], k[axis]);
            clip = vec2(max(clip.x, slab.x), min(clip.y, slab.y));
        }
    }
    float s = nowhere;
    for (int i = 1; i >= 0; --i) {
        bool is_in = has_roots && roots[i] >= clip.x && roots[i] <= clip.y && t_base + roots[i] >= t_near;
        s = is_in ? roots[i] : s;
    }
    bool is_hit = s < nowhere;
    vec3 q = p + k * s;
    vec3 normal = transpose(quadric.local_from_view) * half_gradient(kind, quadric, q);
    normal = normal == vec3(0.0) ? -v : normal;
    QuadricHit hit = QuadricHit(is_hit ? t_base + s : nowhere, normalize(normal), q, false);
    if (kind == cone) {
        // Caps are tested by the order of the same roots, not by f: no gap at their rims.
        for (int end = 0; end < 2; ++end) {
            float side = end == 0 ? -1.0 : 1.0;
            float at = (side - p.z) / k.z;
            bool is_between = at >= roots.x && at <= roots.y;
            bool is_within = f.alpha == 0.0 ? f.gamma + 2.0 * f.beta * at <= 0.0
                             : !has_roots   ? f.alpha < 0.0
                             : f.alpha > 0.0 ? is_between
                                             : at <= roots.x || at >= roots.y;
            bool is_first = t_base + at >= t_near && t_base + at < hit.t;
            if (quadric.has_cap[end] && k.z != 0.0 && is_within && is_first)
                hit = QuadricHit(t_base + at,
                                 normalize(side * transpose(quadric.local_from_view)[2]),
                                 p + k * at, true);
        }
    }
    return hit;
}

QuadricHit first_hit(int kind, Quadric quadric, vec2 slope, float t_near) {
    return first_hit(kind, quadric, vec3(slope, -1.0), closest_approach_in_view(quadric.centre, slope), t_near);
}
