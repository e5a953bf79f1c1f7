// Planes that cut primitives open.
// SPDX-License-Identifier: MPL-2.0
// twin  quadrics/cut.h, raycaster/primitives_reference.cpp
#include "quadrics/quadric.glsl"
//
// CUT_PLANES: how many; CUT_LOOK, by CutLook: 0 the inside, 1 flat, 2 capped.

#if CUT_PLANES > 0
uniform vec4 u_cut_planes[CUT_PLANES]; // axes of the rays, from the eye: cut away is where dot(xyz, p) > w
#endif

// What the planes leave of a ray.
struct Kept {
    float t_near, t_far;
    vec3 normal; // of the plane at t_near; 0 if that is the ray's start
};

Kept kept_by_planes(vec3 v, vec3 start) {
    Kept kept = Kept(0.0, nowhere, vec3(0.0));
#if CUT_PLANES > 0
    for (int i = 0; i < CUT_PLANES; ++i) {
        vec4 plane = u_cut_planes[i];
        float towards = dot(plane.xyz, v);
        float room = plane.w - dot(plane.xyz, start);
        float t = towards == 0.0 ? (room < 0.0 ? -1.0 : nowhere) : room / towards;
        if (towards >= 0.0) kept.t_far = min(kept.t_far, t);
        else if (t > kept.t_near) {
            kept.t_near = t;
            kept.normal = plane.xyz;
        }
    }
#endif
    return kept;
}
Kept kept_by_planes(vec2 slope, vec3 start) { return kept_by_planes(vec3(slope, -1.0), start); }

// The hit of a primitive that may have been cut, found from t_near on.
//
// depth_inside  of the ray at t_near, for caps
QuadricHit cut_hit(QuadricHit hit, Kept kept, vec3 v, float depth_inside) {
#if CUT_PLANES > 0
    bool is_cut = kept.normal != vec3(0.0);
#if CUT_LOOK == 1
    if (is_cut && dot(hit.normal, v) > 0.0) {
        hit.normal = kept.normal;
        hit.is_cap = true;
    }
#elif CUT_LOOK == 2
    if (is_cut && depth_inside < 0.0) hit = QuadricHit(kept.t_near, kept.normal, vec3(0.0), true);
#endif
    if (hit.t > kept.t_far) hit.t = nowhere;
#endif
    return hit;
}
QuadricHit cut_hit(QuadricHit hit, Kept kept, vec2 slope, float depth_inside) {
    return cut_hit(hit, kept, vec3(slope, -1.0), depth_inside);
}

// Distances by which hits are ordered. Caps of one plane are equally far away: the solid that the ray
// is deepest in comes first, however they are drawn; no other hit lies before a cap.
float distance_in_order(QuadricHit hit, Kept kept, float depth_inside) {
#if CUT_PLANES > 0 && CUT_LOOK == 2
    bool is_cap_of_cut = kept.normal != vec3(0.0) && depth_inside < 0.0;
    return is_cap_of_cut ? hit.t * (1.0 + 0.5 * depth_inside / (1.0 - depth_inside)) : hit.t;
#else
    return hit.t;
#endif
}

// The twins of quadrics/cut.h; only caps need them.
float depth_inside_quadric(int kind, Quadric quadric, vec3 v, float t) {
#if CUT_PLANES > 0 && CUT_LOOK == 2
    vec3 q = quadric.local_from_view * (v * t - quadric.centre);
    if (kind == ball) return dot(q, q) - 1.0;
    if (kind == cone) {
        float r = quadric.radius_middle + quadric.radius_slope * q.z;
        return max(q.z * q.z - 1.0, dot(q.xy, q.xy) - r * r);
    }
    float size = max(max(abs(q.x), abs(q.y)), abs(q.z));
    return max(size * size - 1.0, dot(q, quadric.a * q) + 2.0 * dot(quadric.b, q) + quadric.c);
#else
    return 0.0;
#endif
}
float depth_inside_quadric(int kind, Quadric quadric, vec2 slope, float t) {
    return depth_inside_quadric(kind, quadric, vec3(slope, -1.0), t);
}
