// Ambient occlusion: the share of a sky of even light that is seen, by rays through the field.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/pixel.glsl"
#include "raycast/march.glsl"
#include "raycast/walk.glsl"
#include "shading/disc.glsl"

layout(binding = 3) uniform sampler2D t_hit;
layout(binding = 4) uniform sampler2D t_gradient;
uniform mat3 u_index_from_world;
uniform vec3 u_eye_local;
uniform vec3 u_extent_lo;
uniform vec3 u_extent_hi;
uniform mat3 u_ray_vector; // world axes, affine in the pixel: towards the scene
uniform int u_rays;
uniform float u_distance_world; // how far occluders count
uniform float u_lift_world;     // of the rays' starts off the surface

out float o_occlusion;

// Whether a ray from outside the object meets it: certified, as the picture's rays.
//
// point  from the table's corner [voxels]
// d      of unit length in index space
// side   of the surface on which the ray starts
bool is_blocked(vec3 point, vec3 d, float t_end, float side, Accuracy accuracy) {
    vec3 inverse = inverse_of(d);
    vec3 place = mix(point, floor(point) + 0.5, equal(d, vec3(0.0))); // as in raycast.frag
    vec2 range = clip_to_box(place, inverse, u_extent_lo - u_table_lo, u_extent_hi - u_table_lo);
    range = vec2(0.0, min(range.y, t_end));
    Way way = first_block(place, d, inverse, 0u, point, side, range);
    Block b;
    Search search;
    bool is_hit = false;
    bool is_seeking = has_block(way);
    bool is_marching = is_seeking;
    while (is_marching) {
        while (is_seeking) {
            b = fetch_block(number_of(way));
            vec2 segment = clip_to_box(place, inverse, b.lo, b.lo + block_size);
            segment = vec2(max(segment.x, range.x), min(segment.y, range.y));
            search = search_of(b, accuracy, point, segment, d, inverse);
            if (!search.is_on) way = next_block(way, false, place, d, inverse);
            is_seeking = !search.is_on && has_block(way);
        }
        if (search.is_on) {
            look(b, accuracy, point, d, inverse, side, search);
            is_hit = search.is_bracketed; // there is a root; where does not matter
            is_seeking = !search.is_on && !is_hit;
            if (is_seeking) way = next_block(way, false, place, d, inverse);
            is_seeking = is_seeking && has_block(way);
        }
        is_marching = !is_hit && (search.is_on || is_seeking);
    }
    return is_hit;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 hit = texelFetch(t_hit, pixel, 0);
    vec3 gradient = texelFetch(t_gradient, pixel, 0).xyz;
    float length_g = length(gradient);
    float side = dot(gradient, u_ray_vector * vec3(1.0, picture_pixel())) > 0.0 ? -1.0 : 1.0;
    vec3 n = side * gradient / max(length_g, 1e-30); // 1e-30: no division by zero
    // Tangents without cancellation whatever the normal: Duff et al., JCGT 2017.
    float s = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    vec3 u = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    vec3 v = vec3(b, s + n.y * n.y * a, -n.y);
    vec3 point = u_eye_local + u_index_from_world * (hit.xyz + u_lift_world * n) - u_table_lo;
    float turns = turns_of_pixel(picture_pixel());
    Accuracy accuracy = accuracy_of_frame();
    // Where the gradient vanishes there is no sky to look at.
    int count = hit.w != 0.0 && length_g > 0.0 ? u_rays : 0;
    int blocked = 0;
    for (int i = 0; i < count; ++i) {
        // Even on the disc below the sky, so by the cosine on the sky.
        vec2 q = disc_point(i, u_rays, turns);
        vec3 to_sky = q.x * u + q.y * v + sqrt(1.0 - dot(q, q)) * n;
        vec3 way = u_index_from_world * to_sky;
        float voxels = length(way);
        if (is_blocked(point, way / voxels, u_distance_world * voxels, side, accuracy)) ++blocked;
    }
    o_occlusion = 1.0 - float(blocked) / float(u_rays);
}
