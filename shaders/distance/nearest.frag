// A distance that the sample's own is surely below, by minimum blending.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "distance/section.glsl"

flat in vec4 v_value;
flat in vec4 v_along_x;
flat in vec4 v_along_y;
flat in vec2 v_first_pixel;
flat in float v_error;
out float o_bound;

void main() {
    vec2 d = gl_FragCoord.xy - v_first_pixel;
    Reach reach = reach_of(v_value + v_along_x * d.x + v_along_y * d.y);
    // Beside the tower the plane is no part of the mesh: only samples surely within count.
    o_bound = reach.outside <= -v_error ? reach.distance + v_error : 1e30;
}
