// Where a pixel's ray meets the plane of a face; blending keeps the least of each.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/ray.glsl"
#include "raycast/parts.glsl"

flat in int v_axis;
flat in float v_plane; // from the table's corner [voxels]

out vec2 o_bounds; // t, -t

void main() {
    Ray ray = pixel_ray();
    float t = (v_plane - (ray.point - u_table_lo)[v_axis]) * inverse_of(ray.direction)[v_axis];
    o_bounds = vec2(t, -t);
}
