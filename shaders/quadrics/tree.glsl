// Whether a ray from anywhere meets one of the primitives, through a tree of boxes around them.
// SPDX-License-Identifier: MPL-2.0
// twin  quadrics/primitive_tree.h
#include "quadrics/splat.glsl"
//
// HAS_0 ... HAS_8: whether there are primitives of each kind (quadrics/splats.h: SplatKind).
#if HAS_4
#include "quadrics/superquadric.glsl"
#endif
#if HAS_6
#include "quadrics/patch.glsl"
#endif
#if HAS_7
#include "quadrics/tetrahedron.glsl"
#endif
#if HAS_8
#include "quadrics/slim.glsl"
#endif

layout(binding = 6) uniform isamplerBuffer t_tree;  // two for each node
layout(binding = 7) uniform samplerBuffer t_bodies; // of leaves
uniform int u_nodes;
#if HAS_8
uniform vec2 u_coarse; // how far SLIM surfaces may be off where they are drawn: by the distance, and at any
#endif

// Of starts off the surface, by their distance from the eye. 2^-18: hits lie on surfaces to 1e-6 of it
// (docs/molecules.md), and eight roundings of what follows are half as much.
const float lift_share = exp2(-18.0);

// f at the start, by f(eye) where the eye is within 4 sizes: right at a surface that is large from there, and
// whose own numbers are too large to tell on which side of it the start is. From farther f(eye) would err more.
Quadric seen_from_start(int kind, Quadric quadric, vec3 start) {
    vec3 eye = -(quadric.local_from_view * quadric.centre);
    vec3 way = quadric.local_from_view * start;
    Quadratic by_eye = along_ray(kind, quadric, eye, way);
    float of_eye = quadric.value_at_start + 2.0 * by_eye.beta + by_eye.alpha;
    quadric.centre -= start;
    vec3 at_start = -(quadric.local_from_view * quadric.centre);
    quadric.value_at_start = quadric.is_near ? of_eye : along_ray(kind, quadric, at_start, way).gamma;
    quadric.is_near = dot(at_start, at_start) <= 16.0; // as quadrics/quadric.cpp
    return quadric;
}

float sphere_value_at(vec3 start, float at_eye, vec4 sphere) {
    float by_eye = at_eye + dot(start, start - 2.0 * sphere.xyz);
    float distance = length(sphere.xyz - start);
    return at_eye <= 15.0 * sphere.w * sphere.w ? by_eye : (distance - sphere.w) * (distance + sphere.w);
}

// From anywhere; the quadric as seen from the eye.
float quadric_distance(int kind, Quadric quadric, vec3 start, vec3 v, Kept kept) {
    quadric = seen_from_start(kind, quadric, start);
    QuadricHit hit = first_hit(kind, quadric, v, closest_approach(quadric.centre, v), kept.t_near);
    return cut_hit(hit, kept, v, depth_inside_quadric(kind, quadric, v, kept.t_near)).t;
}

#if HAS_5
// The same signs as quadrics/triangle.glsl, by the corners.
float triangle_distance(vec3 corners[3], vec4 plane, vec3 start, vec3 v) {
    vec3 volumes, roundings;
    for (int i = 0; i < 3; ++i) {
        vec3 a = corners[(i + 1) % 3] - start;
        vec3 side = corners[(i + 2) % 3] - corners[(i + 1) % 3];
        volumes[i] = dot(v, cross(a, side));
        roundings[i] = exp2(-21.0) * length(a) * length(side);
    }
    bool is_inside = all(greaterThanEqual(volumes, -roundings)) || all(lessThanEqual(volumes, roundings));
    float slant = dot(plane.xyz, v);
    float t = (plane.w - dot(plane.xyz, start)) / slant;
    return is_inside && slant != 0.0 && t > 0.0 ? t : nowhere;
}
#endif

// start  from the eye, world axes
// v      of unit length
bool meets_any(vec3 start, vec3 v, float t_end) {
    Kept kept = kept_by_planes(v, start);
    vec2 range = vec2(kept.t_near, min(kept.t_far, t_end));
    vec3 inverse = 1.0 / mix(v, vec3(1e-30), equal(v, vec3(0.0)));
    bool is_met = false;
    int node = range.x <= range.y ? 0 : u_nodes;
    while (node < u_nodes && !is_met) {
        int leaf = -1;
        int look = 0;
        for (bool is_seeking = true; is_seeking;) {
            ivec4 lo = texelFetch(t_tree, 2 * node);
            ivec4 hi = texelFetch(t_tree, 2 * node + 1);
            vec3 to_lo = (intBitsToFloat(lo.xyz) - start) * inverse;
            vec3 to_hi = (intBitsToFloat(hi.xyz) - start) * inverse;
            vec3 first = min(to_lo, to_hi);
            vec3 last = max(to_lo, to_hi);
            float enters = max(max(first.x, first.y), max(first.z, range.x));
            float leaves = min(min(last.x, last.y), min(last.z, range.y));
            // 2^-21: more than the roundings of both (Ize 2013).
            bool is_in = enters <= leaves * (1.0 + exp2(-21.0));
            bool is_leaf = lo.w < 0;
            look = lo.w;
            leaf = is_in && is_leaf ? hi.w : -1;
            node += is_in || is_leaf ? 1 : lo.w;
            is_seeking = leaf < 0 && node < u_nodes;
        }
        int code = -1 - look;
        int count = leaf < 0 ? 0 : (code >> 4) + 1;
        int kind = code & 15;
#if HAS_0
        for (int left = kind == 0 ? count : 0; left > 0 && !is_met; --left, leaf += 2) {
            float at_eye = texelFetch(t_bodies, leaf).x;
            vec4 sphere = texelFetch(t_bodies, leaf + 1);
            float gamma = sphere_value_at(start, at_eye, sphere);
            ClosestApproach closest = closest_approach(sphere.xyz - start, v);
            QuadricHit hit = sphere_hit(gamma, sphere.w, v, closest, kept.t_near);
            hit = cut_hit(hit, kept, v, depth_inside_sphere(sphere, v, start, kept.t_near));
            is_met = hit.t <= range.y;
        }
#endif
#if HAS_1
        for (int left = kind == 1 ? count : 0; left > 0 && !is_met; --left, leaf += 4) {
            Quadric quadric = ellipsoid_of(texelFetch(t_bodies, leaf), texelFetch(t_bodies, leaf + 1),
                                           texelFetch(t_bodies, leaf + 2), texelFetch(t_bodies, leaf + 3),
                                           vec3(0.0));
            is_met = quadric_distance(ball, quadric, start, v, kept) <= range.y;
        }
#endif
#if HAS_2
        for (int left = kind == 2 ? count : 0; left > 0 && !is_met; --left, leaf += 3) {
            Quadric quadric = cone_of(texelFetch(t_bodies, leaf), texelFetch(t_bodies, leaf + 1),
                                      texelFetch(t_bodies, leaf + 2), vec3(0.0));
            is_met = quadric_distance(cone, quadric, start, v, kept) <= range.y;
        }
#endif
#if HAS_3
        for (int left = kind == 3 ? count : 0; left > 0 && !is_met; --left, leaf += 7) {
            Quadric quadric = general_of(texelFetch(t_bodies, leaf), texelFetch(t_bodies, leaf + 1),
                                         texelFetch(t_bodies, leaf + 2), texelFetch(t_bodies, leaf + 3),
                                         texelFetch(t_bodies, leaf + 4), texelFetch(t_bodies, leaf + 5),
                                         texelFetch(t_bodies, leaf + 6), vec3(0.0));
            is_met = quadric_distance(general, quadric, start, v, kept) <= range.y;
        }
#endif
#if HAS_4
        for (int left = kind == 4 ? count : 0; left > 0 && !is_met; --left, leaf += 4) {
            Superquadric body = superquadric_of(texelFetch(t_bodies, leaf), texelFetch(t_bodies, leaf + 1),
                                                texelFetch(t_bodies, leaf + 2), texelFetch(t_bodies, leaf + 3),
                                                start);
            // N is convex: what starts on the surface, as far as Newton's steps know it, and leaves does
            // not come back.
            mat3 m = body.local_from_view;
            vec4 n = superquadric_norm(-(m * body.centre), body);
            bool leaves = kept.t_near == 0.0 && n.w >= 1.0 - exp2(-20.0) && dot(n.xyz, m * v) >= 0.0;
            QuadricHit hit = superquadric_hit(body, v, closest_approach(body.centre, v), kept.t_near);
            hit = cut_hit(hit, kept, v, depth_inside_superquadric(body, v, kept.t_near));
            is_met = !leaves && hit.t <= range.y;
        }
#endif
#if HAS_5
        for (int left = kind == 5 ? count : 0; left > 0 && !is_met; --left, leaf += 4) {
            vec3 corners[3] = vec3[3](texelFetch(t_bodies, leaf).xyz, texelFetch(t_bodies, leaf + 1).xyz,
                                      texelFetch(t_bodies, leaf + 2).xyz);
            float t = triangle_distance(corners, texelFetch(t_bodies, leaf + 3), start, v);
            is_met = t >= kept.t_near && t <= range.y;
        }
#endif
#if HAS_6
        for (int left = kind == 6 ? count : 0; left > 0 && !is_met; --left, leaf += 4) {
            BilinearPatch body = patch_of(texelFetch(t_bodies, leaf), texelFetch(t_bodies, leaf + 1),
                                          texelFetch(t_bodies, leaf + 2), texelFetch(t_bodies, leaf + 3), start);
            is_met = patch_distance(body, v, kept.t_near) <= range.y;
        }
#endif
#if HAS_7
        for (int left = kind == 7 ? count : 0; left > 0 && !is_met; --left, leaf += 11) {
            vec4 body[6];
            for (int i = 0; i < 6; ++i) body[i] = texelFetch(t_bodies, leaf + i);
            is_met = tetrahedron_distance(body, start, v, kept.t_near) <= range.y;
        }
#endif
#if HAS_8
        for (int left = kind == 8 ? count : 0; left > 0 && !is_met; --left, leaf += 7) {
            vec4 body[7];
            for (int i = 0; i < 7; ++i) body[i] = texelFetch(t_bodies, leaf + i);
            float t = slim_distance(body, start, v, kept.t_near,
                                    u_coarse.x * length(start) + u_coarse.y);
            is_met = t <= range.y;
        }
#endif
    }
    return is_met;
}
