// Rays from a hit to the sky over it.
// SPDX-License-Identifier: MPL-2.0
#include "common/pixel.glsl"
#include "shading/disc.glsl"

layout(binding = 3) uniform sampler2D t_hit;
layout(binding = 4) uniform sampler2D t_gradient;
uniform mat3 u_view_vector; // world axes, affine in the pixel: towards the scene
uniform int u_rays;
uniform float u_distance_world; // how far occluders count

struct Sky {
    bool is_there; // there is a hit, and its gradient does not vanish
    vec3 start;    // from the eye, world axes
    float side;    // of the surface on which rays start
    mat3 axes;     // world axes: two tangents and the normal
    float turns;   // of the rays' directions
};

// lift_world, lift_share  of the start off the surface, the second by its distance from the eye
Sky sky_of_pixel(float lift_world, float lift_share) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 hit = texelFetch(t_hit, pixel, 0);
    vec3 gradient = texelFetch(t_gradient, pixel, 0).xyz;
    float length_g = length(gradient);
    float side = dot(gradient, u_view_vector * vec3(1.0, picture_pixel())) > 0.0 ? -1.0 : 1.0;
    vec3 n = side * gradient / max(length_g, 1e-30); // 1e-30: no division by zero
    // Tangents without cancellation whatever the normal: Duff et al., JCGT 2017.
    float s = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    vec3 u = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    vec3 v = vec3(b, s + n.y * n.y * a, -n.y);
    vec3 start = hit.xyz + (lift_world + lift_share * length(hit.xyz)) * n;
    return Sky(hit.w != 0.0 && length_g > 0.0, start, side, mat3(u, v, n), turns_of_pixel(picture_pixel()));
}

// The direction of ray i.
vec3 way_to_sky(Sky sky, int i) {
    // Even on the disc below the sky, so by the cosine on the sky.
    vec2 q = disc_point(i, u_rays, sky.turns);
    return sky.axes * vec3(q, sqrt(1.0 - dot(q, q)));
}
