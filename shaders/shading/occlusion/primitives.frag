// Ambient occlusion of primitives alone: the share of a sky of even light that is seen.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "quadrics/tree.glsl"
#include "shading/occlusion/sky.glsl"

out float o_occlusion;

void main() {
    Sky sky = sky_of_pixel(0.0, lift_share);
    // Where there is no normal there is no sky to look at.
    int count = sky.is_there ? u_rays : 0;
    int blocked = 0;
    for (int i = 0; i < count; ++i)
        if (meets_any(sky.start, way_to_sky(sky, i), u_distance_world)) ++blocked;
    o_occlusion = 1.0 - float(blocked) / float(u_rays);
}
