// Which splat a pixel's ray meets first.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "quadrics/splat.glsl"

flat in vec4 v_splat[FLOATS4 - 1];
flat in float v_slot;
// Depths are this by the distance along the view: floats keep their digits at any.
uniform float u_depth_unit;

layout(location = 0) out float o_splat;

void main() {
    vec3 v = ray_vector();
    vec3 start = ray_start();
#if KIND == 0
    QuadricHit hit = sphere_hit(v_splat[0], v_splat[1], v, start);
#elif KIND == 3
    QuadricHit hit = first_hit(general,
                               general_of(v_splat[0].w, v_splat[1], v_splat[2], v_splat[3], v_splat[4],
                                          v_splat[5], v_splat[6], v_splat[7], start),
                               v, 0.0);
#else
    QuadricHit hit = first_hit(
        KIND == 1 ? ball : cone,
        ellipsoid_of(v_splat[0].w, v_splat[1], v_splat[2], v_splat[3], v_splat[4], start), v, 0.0);
#endif
    if (hit.t >= nowhere) discard;
    o_splat = v_slot;
    gl_FragDepth = u_depth_unit / hit.t;
}
