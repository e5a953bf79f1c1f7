// Which splat a pixel's ray meets first.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "quadrics/splat.glsl"
#if KIND == 4
#include "quadrics/superquadric.glsl"
#elif KIND == 6
#include "quadrics/patch.glsl"
#elif KIND == 7
#include "quadrics/tetrahedron.glsl"
#elif KIND == 8
#include "quadrics/slim.glsl"
#endif
#if BY_EQUATION_7
#include "quadrics/equation_7.glsl"
#endif
#if HAS_NORMALS
#include "quadrics/triangle_normals.glsl"
#endif
#if OUTPUT == 3
#include "quadrics/direct.glsl"
#elif HAS_NORMALS
uniform mat3 u_world_from_view;
#endif

// OUTPUT: raycaster/splat_passes.h, SplatOutput.
flat in vec4 v_splat[FLOATS4 - PLACE4];
#if OUTPUT == 1
uniform float u_units_per_world; // the least of all distances is kept
#else
// Depths are this by the distance along the view: floats keep their digits at any.
uniform float u_depth_unit;
#endif
#if HAS_NORMALS
flat in float v_triangle;
#endif

#if OUTPUT == 2
#include "common/octahedral.glsl"
layout(location = 0) out uvec2 o_surface;
#elif OUTPUT == 3
layout(location = 0) out vec4 o_beauty; // linear RGB, coverage
#else
layout(location = 0) out float o_splat; // its number, or how far away it is
#endif

void main() {
    vec2 slope = ray_slope();
    vec3 start = ray_start();
    Kept kept = kept_by_planes(slope, start);
#if KIND == 0
#if BY_EQUATION_7
    QuadricHit hit = sphere_hit_by_equation_7(v_splat[1]);
#else
    QuadricHit hit = sphere_hit(v_splat[0], v_splat[1], slope, start, kept.t_near);
#endif
    float depth_inside = depth_inside_sphere(v_splat[1], slope, start, kept.t_near);
    float number = v_splat[0].y;
#elif KIND == 4
    Superquadric body = superquadric_of(v_splat[0], v_splat[1], v_splat[2], v_splat[3], start);
    QuadricHit hit = superquadric_hit(body, slope, kept.t_near);
    float depth_inside = depth_inside_superquadric(body, slope, kept.t_near);
    float number = v_splat[2].w;
#elif KIND == 5
    QuadricHit hit = triangle_hit(vec4[3](v_splat[0], v_splat[1], v_splat[2]), v_splat[3], ray_at());
    if (hit.t < kept.t_near) hit.t = nowhere;
    const float depth_inside = 0.0;
    float number = v_splat[2].w;
#elif KIND == 6
    BilinearPatch body = patch_of(v_splat[0], v_splat[1], v_splat[2], v_splat[3], start);
    QuadricHit hit = patch_hit(body, slope, kept.t_near);
    const float depth_inside = 0.0;
    float number = v_splat[2].w;
#elif KIND == 7
    QuadricHit hit = tetrahedron_hit(v_splat, ray_at(), kept.t_near);
    const float depth_inside = 0.0;
    float number = v_splat[2].w;
#elif KIND == 8
    SlimFragment piece = slim_fragment(v_splat, slope, start, kept.t_near);
    // Behind what the sheet's pieces may show, for shadows; of what light grazes no farther, since it is dark.
    float behind = 2.0 * min(piece.reach, 2.0 * v_splat[3].w);
    QuadricHit hit = QuadricHit(piece.t + behind, piece.half_gradient / piece.slope, vec3(0.0), false);
    const float depth_inside = 0.0;
    float number = v_splat[2].w;
#else
#if KIND == 1
    Quadric quadric = ellipsoid_of(v_splat[0], v_splat[1], v_splat[2], v_splat[3], start);
    const int kind = ball;
#elif KIND == 2
    Quadric quadric = cone_of(v_splat[0], v_splat[1], v_splat[2], start);
#if ARE_STICKS // open cylinders alone: most of the code goes
    quadric.radius_middle = 1.0;
    quadric.radius_slope = 0.0;
    quadric.has_cap = bvec2(false);
#endif
    const int kind = cone;
#else
    Quadric quadric = general_of(v_splat[0], v_splat[1], v_splat[2], v_splat[3], v_splat[4], v_splat[5],
                                 v_splat[6], start);
    const int kind = general;
#endif
    QuadricHit hit = first_hit(kind, quadric, slope, kept.t_near);
    float depth_inside = depth_inside_quadric(kind, quadric, slope, kept.t_near);
    float number = v_splat[2].w;
#endif
    hit = cut_hit(hit, kept, slope, depth_inside);
    if (hit.t >= nowhere) discard;
#if OUTPUT == 1
    o_splat = u_units_per_world * hit.t;
#else
    gl_FragDepth = u_depth_unit / distance_in_order(hit, kept, depth_inside);
#endif
#if HAS_NORMALS
    hit.normal = normal_of_corners(hit, int(v_triangle), transpose(u_world_from_view), vec3(slope, -1.0));
#endif
#if KIND == 2
    bool is_b = is_in_half_b(hit, quadric, slope);
#else
    const bool is_b = false;
#endif
#if OUTPUT == 0
    o_splat = number;
#elif OUTPUT == 2
    o_surface = uvec2(uint(number) + (is_b ? 0x80000001u : 1u), packed_direction(hit.normal));
#elif OUTPUT == 3
    o_beauty = vec4(direct_colour(hit, is_b, start + vec3(slope, -1.0) * hit.t), 1.0);
#endif
}
