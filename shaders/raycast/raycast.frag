// First hit of each ray with the isosurface: march on one lattice, then refine (thesis sections
// 6.3.3 and 6.3.4).
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/ray.glsl"
#include "raycast/bounds.glsl"
#include "raycast/field.glsl"

layout(binding = 2) uniform sampler2D t_bounds;
uniform float u_fine_step;      // 1 / r1 [voxels]
uniform int u_fine_per_coarse;  // n: r1 = n r0
uniform float u_near_threshold; // delta: closer to iso than this, steps are fine [world]
uniform int u_refinement_steps;
uniform mat3 u_world_from_index;

out vec4 o_hit; // eye-relative position [world], object (0: none)

// Root of the field between t0 and t1, whose values have opposite signs: regula falsi (eq. 6.4)
// that halves the value at an end which stays twice, so that it cannot stall there.
float refine(Ray ray, float t0, float f0, float t1, float f1) {
    float t = t1;
    int stayed = 0;
    for (int i = 0; i < u_refinement_steps; ++i) {
        t = t0 + (t1 - t0) * (f0 / (f0 - f1));
        float f = field_value(ray.point + t * ray.direction);
        if ((f < 0.0) == (f0 < 0.0)) {
            t0 = t;
            f0 = f;
            if (stayed == 1) f1 *= 0.5;
            stayed = 1;
        } else {
            t1 = t;
            f1 = f;
            if (stayed == -1) f0 *= 0.5;
            stayed = -1;
        }
    }
    return t0 + (t1 - t0) * (f0 / (f0 - f1));
}

// Parameters at which a ray enters and leaves the box of the field's samples.
vec2 clip_to_extent(Ray ray) {
    // 1e-30: a direction along a face must not divide zero by zero.
    vec3 d = mix(ray.direction, vec3(1e-30), equal(ray.direction, vec3(0.0)));
    vec3 t0 = (u_extent_lo - ray.point) / d;
    vec3 t1 = (u_extent_hi - ray.point) / d;
    vec3 t_in = min(t0, t1);
    vec3 t_out = max(t0, t1);
    return vec2(max(t_in.x, max(t_in.y, t_in.z)), min(t_out.x, min(t_out.y, t_out.z)));
}

void main() {
    o_hit = vec4(0.0);
    vec4 bounds = texelFetch(t_bounds, ivec2(gl_FragCoord.xy), 0);
    if (!has_bounds(bounds)) return;
    Ray ray = pixel_ray(gl_FragCoord.xy);
    vec2 range = entry_and_exit(bounds, ray.t_start);
    vec2 clip = clip_to_extent(ray);
    clip.x = max(clip.x, ray.t_start);

    // Samples lie at t = k * fine step, k an integer, whatever the blocks and bricks; coarse ones
    // where n divides k. One coarse step of margin at both ends covers the rounding of the bounds.
    // The first and the last sample lie on the extent or at the ray's start where that cuts in.
    int n = u_fine_per_coarse;
    float coarse_step = u_fine_step * float(n);
    float t_first = max((floor(range.x / coarse_step) - 1.0) * coarse_step, clip.x);
    float t_last = min((ceil(range.y / coarse_step) + 1.0) * coarse_step, clip.y);

    int k = int(floor(t_first / u_fine_step));
    float t_before = t_first;
    float f_before = field_value(ray.point + t_before * ray.direction);
    while (t_before < t_last) {
        // To the next lattice point, fine or coarse; n may not divide k after fine steps.
        k = abs(f_before) < u_near_threshold ? k + 1 : (k >= 0 ? k / n + 1 : -((-k - 1) / n)) * n;
        float t = min(float(k) * u_fine_step, t_last);
        float f = field_value(ray.point + t * ray.direction);
        if ((f < 0.0) != (f_before < 0.0)) {
            float t_hit = refine(ray, t_before, f_before, t, f);
            o_hit = vec4(u_world_from_index * (ray.from_eye + t_hit * ray.direction), 1.0);
            return;
        }
        t_before = t;
        f_before = f;
    }
}
