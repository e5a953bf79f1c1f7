// What the bounds image holds: x the nearest front face, y the nearest back face, z minus the
// farthest back face, as parameters of the pixel's ray [voxels].
// SPDX-License-Identifier: MPL-2.0

const float no_bound = 1.0e30; // the clear value; raycaster/passes.cpp

bool has_bounds(vec4 bounds) { return bounds.y < no_bound; }

// Entry and exit. A ray that leaves before it enters starts inside.
vec2 entry_and_exit(vec4 bounds, float t_start) {
    return vec2(bounds.y < bounds.x ? t_start : max(bounds.x, t_start), -bounds.z);
}
