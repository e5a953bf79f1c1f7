// A sphere's hit as the paper has it, for comparison: the quadratic of the depth in the window, in floats.
// SPDX-License-Identifier: MPL-2.0
// source  Sigg et al. 2006 eqs 6 - 9 (thesis 7.11 - 7.15)
#include "common/pixel.glsl" // before #if, since a file is included once
#include "quadrics/quadric.glsl"

uniform mat4 u_view_from_window; // (V P)^-1

QuadricHit sphere_hit_by_equation_7(vec4 sphere) {
    // (M T)^-1: to where the sphere is that of radius 1 about 0.
    mat4 parameter_from_view = mat4(mat3(1.0 / sphere.w));
    parameter_from_view[3].xyz = -sphere.xyz / sphere.w;
    vec4 x = parameter_from_view * (u_view_from_window * vec4(picture_pixel(), 0.0, 1.0));
    vec4 c = parameter_from_view * u_view_from_window[2];
    vec4 d = vec4(1.0, 1.0, 1.0, -1.0);
    float alpha = dot(c * d, c);
    float beta = dot(x * d, c);
    float gamma = dot(x * d, x);
    float discriminant = beta * beta - alpha * gamma;
    float root = sqrt(max(discriminant, 0.0));
    float z = min((-beta - root) / alpha, (-beta + root) / alpha);
    vec4 p_view = u_view_from_window * vec4(picture_pixel(), z, 1.0);
    vec4 p = x + z * c;
    float t = -p_view.z / p_view.w;
    bool is_hit = discriminant >= 0.0 && t > 0.0;
    return QuadricHit(is_hit ? t : nowhere, normalize(p.xyz / p.w), p.xyz / p.w, false);
}
