// Points lit in each fragment, as if they were half of a sphere.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "shading/blinn_phong/blinn_phong.glsl"

layout(location = 0) out vec4 o_colour;

void main() {
    vec2 at = 2.0 * gl_PointCoord - 1.0;
    vec3 normal = vec3(at.x, -at.y, sqrt(max(1.0 - dot(at, at), 0.0)));
    o_colour = vec4(lit(vec3(0.7, 0.6, 0.4), normalize(normal), vec3(0.0, 0.0, 1.0), 1.0,
                        ShadowOfLight(-1, 1.0)), 1.0);
}
