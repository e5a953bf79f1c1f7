// The hit of a ray with a triangle.
// SPDX-License-Identifier: MPL-2.0
// twin  quadrics/triangle_splats.h: TriangleRay
#include "quadrics/quadric.glsl"
//
// IS_PERSPECTIVE: rays start at the eye.

// Of the edge's number the volume that the ray spans with it: shares of the corners in the hit.
vec3 edge_volumes(vec4 edges[3], vec3 ray) {
    return vec3(dot(edges[0].xyz, ray), dot(edges[1].xyz, ray), dot(edges[2].xyz, ray));
}

// edges  with the least and the greatest distance along the view
// plane  unit normal, offset
// at     the ray's slope, of parallel rays its start
QuadricHit triangle_hit(vec4 edges[3], vec4 plane, vec2 at) {
    vec3 ray = vec3(at, -1.0);
    vec3 volumes = edge_volumes(edges, ray);
    // 2^-22: a coefficient, its product and two sums round. What lies within them is inside: triangles
    // that share an edge or a corner leave no ray between them.
    vec3 roundings = exp2(-22.0) * vec3(dot(abs(edges[0].xyz), abs(ray)), dot(abs(edges[1].xyz), abs(ray)),
                                        dot(abs(edges[2].xyz), abs(ray)));
    bool is_inside = all(greaterThanEqual(volumes, -roundings)) || all(lessThanEqual(volumes, roundings));
#if IS_PERSPECTIVE
    float slant = dot(plane.xyz, ray);
    float height = plane.w;
#else
    float slant = plane.z;
    float height = dot(plane.xy, at) - plane.w;
#endif
    // A ray within the plane meets it anywhere; corners bound where it meets the triangle.
    float t = slant == 0.0 ? edges[0].w : clamp(height / slant, edges[0].w, edges[1].w);
    return QuadricHit(is_inside && t > 0.0 ? t : nowhere, plane.xyz, volumes, false);
}

// As a smooth surface has it; the side that is seen is the triangle's.
vec3 smooth_normal(QuadricHit hit, mat3 of_corners, vec3 direction) {
    vec3 normal = normalize(of_corners * abs(hit.q));
    float away = dot(normal, direction);
    bool is_seen_from_outside = dot(hit.normal, direction) <= 0.0;
    // Near a silhouette it can turn away from the eye though the triangle does not: it is mirrored
    // at the horizon.
    if (is_seen_from_outside == (away > 0.0)) normal -= 2.0 * away / dot(direction, direction) * direction;
    return normal;
}
