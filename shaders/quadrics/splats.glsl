// The splat that a pixel shows.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/splat.glsl"
//
// HAS_0 ... HAS_8: whether there are splats of each kind (quadrics/splats.h: SplatKind).
// HAS_NORMALS: whether triangles have normals at corners.
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
#include "quadrics/slim_blend.glsl"
#endif

layout(binding = 5) uniform sampler2D t_splat; // number + 1; 0: none
layout(binding = 6) uniform samplerBuffer t_splats[8]; // by kind
uniform ivec2 u_slots[9]; // by kind: the first, how many
#if HAS_8
uniform int u_first_slim; // the first SLIM surface's colour
layout(binding = 15) uniform sampler2D t_slim_nearest;
layout(binding = 1) uniform sampler2D t_slim; // sums over their pieces
#if HAS_HESSIAN
layout(binding = 2) uniform sampler2D t_slim_bends[2]; // sums by weight: xx xy xz yy, yz zz - weight
#endif
#endif
#if HAS_NORMALS
#include "quadrics/triangle_normals.glsl"
#endif
#if HAS_2
uniform int u_to_half_colours; // from that of a stick to that of its half at b, if any has two
#endif
uniform mat3 u_world_from_view;

struct Seen {
    QuadricHit hit;
    int colour;    // its number
    float width;   // of the thinnest way through it, about [world]
    mat3 hessian;  // of a function whose gradient is the normal [1/world], view space; flat on caps
};

bool is_of(int slot, int kind) {
    return slot >= u_slots[kind].x && slot < u_slots[kind].x + u_slots[kind].y;
}

// The Hessian of f by the length of its gradient.
mat3 hessian_of(int kind, Quadric quadric, QuadricHit hit) {
#if HAS_HESSIAN
    mat3 m = quadric.local_from_view;
    float gradient = length(transpose(m) * half_gradient(kind, quadric, hit.q));
    return hit.is_cap || gradient == 0.0
               ? mat3(0.0)
               : transpose(m) * half_hessian(kind, quadric) * m / gradient;
#else
    return mat3(0.0);
#endif
}

float width_of(mat3 local_from_view) {
    mat3 rows = transpose(local_from_view);
    return 2.0 * inversesqrt(max(max(dot(rows[0], rows[0]), dot(rows[1], rows[1])), dot(rows[2], rows[2])));
}

// As FrameImage::Gradient has it.
float width_on_picture(Seen seen) {
#if IS_PERSPECTIVE
    float pixels = seen.width / (u_pixel * seen.hit.t);
#else
    float pixels = seen.width / u_pixel;
#endif
    return clamp(pixels / 16.0, 1e-3, 1.0);
}

Seen seen_quadric(int kind, Quadric quadric, int colour, vec2 slope, Kept kept) {
    QuadricHit hit = first_hit(kind, quadric, slope, kept.t_near);
    hit = cut_hit(hit, kept, slope, depth_inside_quadric(kind, quadric, slope, kept.t_near));
#if HAS_2
    if (kind == cone) colour += is_in_half_b(hit, quadric, slope) ? u_to_half_colours : 0;
#endif
    return Seen(hit, colour, width_of(quadric.local_from_view), hessian_of(kind, quadric, hit));
}

// Loops for conditions, since software rasterisers run all sides of a condition; what ends them is
// computed, or the compiler would see that they run but once.
Seen seen_splat(int slot) {
    vec2 slope = ray_slope();
    vec3 start = ray_start();
    Kept kept = kept_by_planes(slope, start);
    Seen seen = Seen(QuadricHit(nowhere, vec3(0.0), vec3(0.0), false), 0, 0.0, mat3(0.0));
#if HAS_0
    for (bool is_here = is_of(slot, 0); is_here; is_here = seen.colour < -1) {
        int at = 3 * (slot - u_slots[0].x);
        vec4 at_eye = texelFetch(t_splats[0], at + 1);
        vec4 sphere = texelFetch(t_splats[0], at + 2);
        QuadricHit hit = sphere_hit(at_eye, sphere, slope, start, kept.t_near);
        hit = cut_hit(hit, kept, slope, depth_inside_sphere(sphere, slope, start, kept.t_near));
#if HAS_HESSIAN
        mat3 hessian = hit.is_cap ? mat3(0.0) : (mat3(1.0) - outerProduct(hit.normal, hit.normal)) / sphere.w;
#else
        mat3 hessian = mat3(0.0);
#endif
        seen = Seen(hit, int(at_eye.y), 2.0 * sphere.w, hessian);
    }
#endif
#if HAS_1
    for (bool is_here = is_of(slot, 1); is_here; is_here = seen.colour < -1) {
        int at = 6 * (slot - u_slots[1].x);
        Quadric quadric = ellipsoid_of(texelFetch(t_splats[1], at + 2),
                                       texelFetch(t_splats[1], at + 3),
                                       texelFetch(t_splats[1], at + 4),
                                       texelFetch(t_splats[1], at + 5), start);
        seen = seen_quadric(ball, quadric, int(texelFetch(t_splats[1], at + 1).z), slope, kept);
    }
#endif
#if HAS_2
    for (bool is_here = is_of(slot, 2); is_here; is_here = seen.colour < -1) {
        int at = 5 * (slot - u_slots[2].x);
        Quadric quadric = cone_of(texelFetch(t_splats[2], at + 2),
                                       texelFetch(t_splats[2], at + 3),
                                       texelFetch(t_splats[2], at + 4), start);
        seen = seen_quadric(cone, quadric, int(texelFetch(t_splats[2], at + 1).z), slope, kept);
    }
#endif
#if HAS_3
    for (bool is_here = is_of(slot, 3); is_here; is_here = seen.colour < -1) {
        int at = 9 * (slot - u_slots[3].x);
        Quadric quadric = general_of(texelFetch(t_splats[3], at + 2),
                                       texelFetch(t_splats[3], at + 3),
                                       texelFetch(t_splats[3], at + 4),
                                       texelFetch(t_splats[3], at + 5),
                                       texelFetch(t_splats[3], at + 6),
                                       texelFetch(t_splats[3], at + 7),
                                       texelFetch(t_splats[3], at + 8), start);
        seen = seen_quadric(general, quadric, int(texelFetch(t_splats[3], at + 1).z), slope, kept);
    }
#endif
#if HAS_4
    for (bool is_here = is_of(slot, 4); is_here; is_here = seen.colour < -1) {
        int at = 6 * (slot - u_slots[4].x);
        Superquadric body = superquadric_of(texelFetch(t_splats[4], at + 2),
                                            texelFetch(t_splats[4], at + 3),
                                            texelFetch(t_splats[4], at + 4),
                                            texelFetch(t_splats[4], at + 5), start);
        QuadricHit hit = superquadric_hit(body, slope, kept.t_near);
        hit = cut_hit(hit, kept, slope, depth_inside_superquadric(body, slope, kept.t_near));
#if HAS_HESSIAN
        mat3 m = body.local_from_view;
        mat3 hessian = hit.is_cap ? mat3(0.0) : transpose(m) * superquadric_norm_hessian(hit.q, body) * m /
                       length(transpose(m) * superquadric_norm(hit.q, body).xyz);
#else
        mat3 hessian = mat3(0.0);
#endif
        seen = Seen(hit, int(texelFetch(t_splats[4], at + 1).z), width_of(body.local_from_view), hessian);
    }
#endif
#if HAS_5
    for (bool is_here = is_of(slot, 5); is_here; is_here = seen.colour < -1) {
        int at = 6 * (slot - u_slots[5].x);
        vec2 numbers = texelFetch(t_splats[5], at + 1).zw;
        QuadricHit hit = triangle_hit(vec4[3](texelFetch(t_splats[5], at + 2),
                                              texelFetch(t_splats[5], at + 3),
                                              texelFetch(t_splats[5], at + 4)),
                                      texelFetch(t_splats[5], at + 5), ray_at());
        if (hit.t < kept.t_near) hit.t = nowhere;
        hit = cut_hit(hit, kept, slope, 0.0);
#if HAS_NORMALS
        hit.normal = normal_of_corners(hit, int(numbers.y), transpose(u_world_from_view), vec3(slope, -1.0));
#endif
        seen = Seen(hit, int(numbers.x), nowhere, mat3(0.0)); // flat, and no thin thing
    }
#endif
#if HAS_6
    for (bool is_here = is_of(slot, 6); is_here; is_here = seen.colour < -1) {
        int at = 6 * (slot - u_slots[6].x);
        BilinearPatch body = patch_of(texelFetch(t_splats[6], at + 2), texelFetch(t_splats[6], at + 3),
                                      texelFetch(t_splats[6], at + 4), texelFetch(t_splats[6], at + 5), start);
        QuadricHit hit = patch_hit(body, slope, kept.t_near);
        hit = cut_hit(hit, kept, slope, 0.0);
#if HAS_HESSIAN
        mat3 hessian = hit.is_cap ? mat3(0.0) : patch_hessian(body, hit);
#else
        mat3 hessian = mat3(0.0);
#endif
        seen = Seen(hit, int(texelFetch(t_splats[6], at + 1).z), nowhere, hessian);
    }
#endif
#if HAS_7
    for (bool is_here = is_of(slot, 7); is_here; is_here = seen.colour < -1) {
        int at = 13 * (slot - u_slots[7].x);
        vec4 body[11];
        for (int i = 0; i < 11; ++i) body[i] = texelFetch(t_splats[7], at + 2 + i);
        QuadricHit hit = tetrahedron_hit(body, ray_at(), kept.t_near);
        hit = cut_hit(hit, kept, slope, 0.0);
#if HAS_HESSIAN
        mat3 hessian = hit.is_cap ? mat3(0.0) : tetrahedron_hessian(body, hit);
#else
        mat3 hessian = mat3(0.0);
#endif
        seen = Seen(hit, int(texelFetch(t_splats[7], at + 1).z), nowhere, hessian);
    }
#endif
#if HAS_8
    for (bool is_here = is_of(slot, 8); is_here; is_here = seen.colour < -1) {
        ivec2 pixel = ivec2(gl_FragCoord.xy);
        vec4 blended = slim_hit(texelFetch(t_slim_nearest, pixel, 0).xy, texelFetch(t_slim, pixel, 0));
        QuadricHit hit = cut_hit(QuadricHit(blended.w, blended.xyz, vec3(0.0), false), kept, slope, 0.0);
#if HAS_HESSIAN
        vec4 first = texelFetch(t_slim_bends[0], pixel, 0);
        vec4 second = texelFetch(t_slim_bends[1], pixel, 0);
        mat3 hessian = hit.is_cap ? mat3(0.0)
                                  : mat3(first.xyz, first.yw, second.x, first.z, second.xy) / second.w;
#else
        mat3 hessian = mat3(0.0);
#endif
        seen = Seen(hit, u_first_slim + slot - u_slots[8].x, nowhere, hessian);
    }
#endif
    return seen;
}
