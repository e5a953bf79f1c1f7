// How splats are written down, and their first hits.
// SPDX-License-Identifier: MPL-2.0
// twin  quadrics/splats.cpp
#include "common/pixel.glsl"
#include "quadrics/cut.glsl"
#include "quadrics/quadric.glsl"
#include "quadrics/triangle.glsl"
//
// IS_PERSPECTIVE: rays start at the eye.

uniform vec2 u_middle_pixel; // where the view's axis meets the picture
uniform float u_pixel; // from a pixel to the next: slope, of parallel rays [world]

// Of the pixel's ray, in view space: its direction is (slope, -1), and where it starts.
#if IS_PERSPECTIVE
vec2 ray_slope() { return u_pixel * (picture_pixel() - u_middle_pixel); }
vec3 ray_start() { return vec3(0.0); }
vec2 ray_at() { return ray_slope(); }
#else
vec2 ray_slope() { return vec2(0.0); }
vec3 ray_start() { return vec3(u_pixel * (picture_pixel() - u_middle_pixel), 0.0); }
vec2 ray_at() { return ray_start().xy; }
#endif

// Roots from the start, by f(start) = gamma: right in front of a large sphere, too.
QuadricHit sphere_hit(float gamma, float radius, vec3 v, ClosestApproach closest, float t_near) {
    float a = dot(v, v);
    float h = radius * radius - dot(closest.y, closest.y); // where it does not cancel
    float half_chord = sqrt(max(h / a, 0.0));
    float b = closest.t;
    float q = b + (b < 0.0 ? -half_chord : half_chord);
    float other = gamma / (a * q);
    float first = min(q, other);
    float t = first >= t_near ? first : max(q, other);
    // By the side of the closest approach that it is on: v t would swallow a small sphere's shape.
    vec3 normal = (closest.y + v * (first >= t_near ? -half_chord : half_chord)) / radius;
    return QuadricHit(h >= 0.0 && t >= t_near ? t : nowhere, normal, normal, false);
}

// Of every kind the first four floats, and of others than spheres two more, are the rectangle, or of
// triangles another around them.
// Spheres: corner, size | f(eye), number, 0, 0 | centre, radius; in view space, from the eye.
QuadricHit sphere_hit(vec4 at_eye, vec4 sphere, vec2 slope, vec3 start, float t_near) {
    vec3 o = sphere.xyz - start;
#if IS_PERSPECTIVE
    float gamma = at_eye.x;
#else
    float distance = length(o);
    float gamma = (distance - sphere.w) * (distance + sphere.w);
#endif
    return sphere_hit(gamma, sphere.w, vec3(slope, -1.0), closest_approach_in_view(o, slope), t_near);
}

float depth_inside_sphere(vec4 sphere, vec3 v, vec3 start, float t) {
#if CUT_PLANES > 0 && CUT_LOOK == 2
    vec3 q = (v * t - (sphere.xyz - start)) / sphere.w;
    return dot(q, q) - 1.0;
#else
    return 0.0;
#endif
}
float depth_inside_sphere(vec4 sphere, vec2 slope, vec3 start, float t) {
    return depth_inside_sphere(sphere, vec3(slope, -1.0), start, t);
}

// Others: corner, side | side, number, 0 | centre, f(eye) | more by kind.
// Ellipsoids: three rows of local_from_view, with flags in the first.
Quadric ellipsoid_of(vec4 centre, vec4 row0, vec4 row1, vec4 row2, vec3 start) {
    int flags = int(row0.w);
    return Quadric(centre.xyz - start, transpose(mat3(row0.xyz, row1.xyz, row2.xyz)), 1.0, 0.0,
                   bvec2(false), mat3(1.0), vec3(0.0), -1.0, centre.w, (flags & 1) != 0);
}
// Cones: unit axis, 1 / half length | 1 / greater radius, slope of the radius, flags, 0.
Quadric cone_of(vec4 centre, vec4 axis, vec4 shape, vec3 start) {
    int flags = int(shape.z);
    // Any two directions across it: Duff et al., JCGT 2017.
    float s = axis.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + axis.z);
    float b = axis.x * axis.y * a;
    vec3 u = vec3(1.0 + s * axis.x * axis.x * a, s * b, -s * axis.x);
    vec3 w = vec3(b, s + axis.y * axis.y * a, -axis.y);
    return Quadric(centre.xyz - start, transpose(mat3(u * shape.x, w * shape.x, axis.xyz * axis.w)),
                   1.0 - abs(shape.y), shape.y, bvec2((flags & 2) != 0, (flags & 4) != 0), mat3(0.0),
                   vec3(0.0), 0.0, centre.w, (flags & 1) != 0);
}
// Whether a hit of it lies in the half at b.
bool is_in_half_b(QuadricHit hit, Quadric quadric, vec2 slope) {
#if CUT_PLANES > 0 && CUT_LOOK == 2
    // Caps of cuts come without a place.
    return (quadric.local_from_view * (vec3(slope, -1.0) * hit.t - quadric.centre)).z > 0.0;
#else
    return hit.q.z > 0.0;
#endif
}
// General ones: as ellipsoids, with c in the third row | a_xx a_xy a_xz b_x | a_yy a_yz a_zz b_y | b_z.
Quadric general_of(vec4 centre, vec4 row0, vec4 row1, vec4 row2, vec4 a, vec4 b, vec4 c, vec3 start) {
    Quadric quadric = ellipsoid_of(centre, row0, row1, row2, start);
    quadric.a = mat3(a.xyz, vec3(a.y, b.xy), vec3(a.z, b.yz));
    quadric.b = vec3(a.w, b.w, c.x);
    quadric.c = row2.w;
    return quadric;
}
// Triangles: corner, side | side, number of the mesh, number | edge, least depth | edge, greatest depth |
// edge, 0 | unit normal, offset. Hits of triangle.glsl. Patches: patch.glsl. Tetrahedra: tetrahedron.glsl.
