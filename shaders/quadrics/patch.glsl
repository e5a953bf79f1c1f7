// The first hit of a ray with a bilinear patch, and how the patch bends there.
// SPDX-License-Identifier: MPL-2.0
// source  Reshetov, Ray Tracing Gems ch. 8: the ruling that the ray meets, then where; by the ray's two
//         coordinates across it instead of volumes, about a point of the patch near the eye
// twin    quadrics/bilinear.h: intersect(), by another equation
#include "quadrics/quadric.glsl"

// The points c + U h + V e + UV d, with U = u - base.x and V = v - base.y, for u and v from 0 to 1.
struct BilinearPatch {
    vec3 c; // from the ray's start
    vec3 h, e, d;
    vec2 base;
};

// As patches are written: corner, side | side, number, 0 | c, base.x | h, base.y | e, 0 | d, 0.
BilinearPatch patch_of(vec4 c, vec4 h, vec4 e, vec4 d, vec3 start) {
    return BilinearPatch(c.xyz - start, h.xyz, e.xyz, d.xyz, vec2(c.w, h.w));
}

float area(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// The hit's t, U and V with the least t >= t_near. t is t_by_z times z; p.xy + slope p.z are the coordinates
// of p across the ray.
vec3 patch_hit_at(BilinearPatch b, vec2 slope, float t_by_z, float t_near) {
    vec2 c = b.c.xy + slope * b.c.z;
    vec2 h = b.h.xy + slope * b.h.z;
    vec2 e = b.e.xy + slope * b.e.z;
    vec2 d = b.d.xy + slope * b.d.z;
    vec3 weights = vec3(1.0, 1.0, abs(slope.x) + abs(slope.y));
    vec4 sizes = weights * mat4x3(abs(b.c), abs(b.h), abs(b.e), abs(b.d));
    // The ruling c + U h, along e + U d, that passes the ray: a U^2 + 2 half U + f = 0.
    float a = area(h, d);
    float half_b = 0.5 * (area(h, e) + area(c, d));
    float f = area(c, e);
    float discriminant = half_b * half_b - a * f;
    float root = sqrt(max(discriminant, 0.0)); // half of the area of the patch there, by u and v
    float q = -(half_b + (half_b < 0.0 ? -root : root));
    vec3 first = vec3(nowhere, 0.0, 0.0);
    for (int i = 0; i < 2; ++i) {
        float u = i == 0 ? f / q : q / a;
        vec2 from = c + u * h;
        vec2 along = e + u * d;
        float v = -dot(from, along) / dot(along, along);
        vec2 across = h + clamp(v, -b.base.y, 1.0 - b.base.y) * d;
        // 2^-23: that far a point may lie off, of what it is the sum of. How far this moves u and v, by the
        // slant of the two directions, is inside: patches that share an edge or a corner leave no ray between
        // them. No farther than a 64th, where the patch is seen edge-on.
        float rounding = exp2(-23.0) * dot(sizes, vec4(1.0, abs(u), abs(v), abs(u * v)));
        vec2 lengths = vec2(length(across), length(along));
        vec2 spare = min(rounding * (1.0 / lengths + lengths.yx / (2.0 * root)), vec2(1.0 / 64.0));
        vec2 at = clamp(vec2(u, v), -b.base, 1.0 - b.base);
        bool is_in = discriminant >= 0.0 && all(lessThanEqual(abs(vec2(u, v) - at), spare));
        float t = t_by_z * (b.c.z + at.x * b.h.z + at.y * (b.e.z + at.x * b.d.z));
        if (is_in && t >= t_near && t < first.x) first = vec3(t, at);
    }
    return first;
}

// With U and V in q.
QuadricHit patch_hit(BilinearPatch b, vec2 slope, float t_near) {
    vec3 hit = patch_hit_at(b, slope, -1.0, t_near);
    vec3 normal = cross(b.h + hit.z * b.d, b.e + hit.y * b.d);
    normal = normal == vec3(0.0) ? vec3(-slope, 1.0) : normal;
    return QuadricHit(hit.x > 0.0 ? hit.x : nowhere, normalize(normal), vec3(hit.yz, 0.0), false);
}

// From anywhere; v of any direction.
float patch_distance(BilinearPatch b, vec3 v, float t_near) {
    vec3 size = abs(v);
    // The longest coordinate last: the other two, by slopes of it, are those across the ray.
    if (size.x > size.z && size.x >= size.y) {
        b = BilinearPatch(b.c.yzx, b.h.yzx, b.e.yzx, b.d.yzx, b.base);
        v = v.yzx;
    } else if (size.y > size.z) {
        b = BilinearPatch(b.c.zxy, b.h.zxy, b.e.zxy, b.d.zxy, b.base);
        v = v.zxy;
    }
    return patch_hit_at(b, -v.xy / v.z, 1.0 / v.z, t_near).x;
}

// Of a function whose gradient is the normal: second derivatives by u alone and by v alone are 0, and with w
// the twist's part along the normal, that by both is -w in the directions' dual basis.
mat3 patch_hessian(BilinearPatch b, QuadricHit hit) {
    vec3 along_u = b.h + hit.q.y * b.d;
    vec3 along_v = b.e + hit.q.x * b.d;
    vec3 across = cross(along_u, along_v);
    float size = length(across);
    vec3 normal = across / size;
    vec3 dual_u = cross(along_v, normal) / size;
    vec3 dual_v = cross(normal, along_u) / size;
    mat3 both = outerProduct(dual_u, dual_v);
    return size > 0.0 ? -dot(b.d, normal) * (both + transpose(both)) : mat3(0.0);
}
