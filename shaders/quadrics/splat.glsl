// How splats are written down, and their first hits.
// SPDX-License-Identifier: MPL-2.0
// twin  quadrics/splats.cpp
#include "common/pixel.glsl"
#include "quadrics/quadric.glsl"
//
// IS_PERSPECTIVE: rays start at the eye.

uniform mat3 u_ray_vector; // world axes, affine in the pixel; a length of 1 along the view
#if !IS_PERSPECTIVE
uniform mat3 u_ray_start; // from the eye [world], affine in the pixel
#endif

vec3 ray_vector() { return u_ray_vector * vec3(1.0, picture_pixel()); }
vec3 ray_start() {
#if IS_PERSPECTIVE
    return vec3(0.0);
#else
    return u_ray_start * vec3(1.0, picture_pixel());
#endif
}

// Of every kind the first four floats, and of others than spheres two more, are the rectangle.
// Spheres: corner, size | f(eye), number, 0, 0 | centre from the eye, radius.
// v: ray_vector(); start: ray_start()
QuadricHit sphere_hit(vec4 at_eye, vec4 sphere, vec3 v, vec3 start) {
    vec3 o = sphere.xyz - start;
    float a = dot(v, v);
    float b = dot(v, o);
    vec3 y = v * (b / a) - o;
    float h = sphere.w * sphere.w - dot(y, y); // at the closest approach, where it does not cancel
#if IS_PERSPECTIVE
    float gamma = at_eye.x;
#else
    float distance = length(o);
    float gamma = (distance - sphere.w) * (distance + sphere.w);
#endif
    float root = sqrt(max(a * h, 0.0));
    float q = b + (b < 0.0 ? -root : root);
    float t1 = gamma / q;
    float t2 = q / a;
    float first = min(t1, t2);
    float t = first >= 0.0 ? first : max(t1, t2);
    vec3 normal = (v * t - o) / sphere.w;
    return QuadricHit(h >= 0.0 && t >= 0.0 ? t : nowhere, normal, normal, false);
}

// Others: corner, side | side, number, flags | centre, f(eye) | three rows of local_from_world with
// the middle radius, the slope of the radius, c | a_xx a_xy a_xz b_x | a_yy a_yz a_zz b_y | b_z.
Quadric ellipsoid_of(float flags, vec4 centre, vec4 row0, vec4 row1, vec4 row2, vec3 start) {
    int bits = int(flags);
    return Quadric(centre.xyz - start, transpose(mat3(row0.xyz, row1.xyz, row2.xyz)), row0.w, row1.w,
                   bvec2((bits & 2) != 0, (bits & 4) != 0), mat3(0.0), vec3(0.0), row2.w, centre.w,
                   (bits & 1) != 0);
}
Quadric general_of(float flags, vec4 centre, vec4 row0, vec4 row1, vec4 row2, vec4 a, vec4 b, vec4 c,
                   vec3 start) {
    Quadric quadric = ellipsoid_of(flags, centre, row0, row1, row2, start);
    quadric.a = mat3(a.xyz, vec3(a.y, b.xy), vec3(a.z, b.yz));
    quadric.b = vec3(a.w, b.w, c.x);
    return quadric;
}
