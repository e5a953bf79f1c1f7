// Normals of triangles that have them at corners.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/triangle.glsl"

layout(binding = 14) uniform samplerBuffer t_normals; // of corners, world axes

vec3 normal_of_corners(QuadricHit hit, int triangle, mat3 view_from_world, vec3 direction) {
    int corner = 3 * triangle;
    mat3 normals = mat3(texelFetch(t_normals, corner).xyz, texelFetch(t_normals, corner + 1).xyz,
                        texelFetch(t_normals, corner + 2).xyz);
    return hit.is_cap ? hit.normal : smooth_normal(hit, view_from_world * normals, direction);
}
