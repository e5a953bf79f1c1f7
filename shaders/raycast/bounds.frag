// Where each ray enters and leaves the active blocks, by minimum blending.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/ray.glsl"
#include "raycast/bounds.glsl"

in vec3 v_p_local;
flat in int v_face;
out vec4 o_bounds;

void main() {
    Ray ray = pixel_ray(gl_FragCoord.xy);
    float t = dot(v_p_local - ray.point, ray.direction);
    float along_normal = ray.direction[v_face >> 1] * ((v_face & 1) == 1 ? 1.0 : -1.0);
    o_bounds = along_normal < 0.0 ? vec4(t, no_bound, no_bound, 0.0)
                                  : vec4(no_bound, t, -t, 0.0);
}
