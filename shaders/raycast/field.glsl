// The field at a point: reference texture, then the brick atlas (thesis section 6.2.2, figure 6.4).
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/brick_atlas.cpp
#include "filtering/tricubic.glsl"

const int brick_size = 32; // volume/bricks.h

layout(binding = 0) uniform sampler3D t_atlas;
// xyz: texel of the brick's corner sample, w 0. Where no brick is stored, w stands for the field.
layout(binding = 1) uniform sampler3D t_reference;
uniform vec3 u_atlas_scale;       // 1 / texels of the atlas
uniform ivec3 u_first_brick_local; // brick of the reference texture's texel 0
uniform vec3 u_extent_lo;          // the field is defined between these [local index coordinates];
uniform vec3 u_extent_hi;          // points beyond by rounding are moved there

struct BrickPoint {
    vec3 corner;    // texel of the sample at floor(p)
    vec3 fraction;  // p - floor(p)
    float constant; // 0, or the field's stand-in where no brick is stored
};

BrickPoint find_brick(vec3 p_local) {
    p_local = clamp(p_local, u_extent_lo, u_extent_hi);
    vec3 cell = floor(p_local);
    ivec3 brick = ivec3(floor(cell / float(brick_size)));
    ivec3 texel = clamp(brick - u_first_brick_local, ivec3(0), textureSize(t_reference, 0) - 1);
    vec4 reference = texelFetch(t_reference, texel, 0);
    return BrickPoint(reference.xyz + (cell - float(brick_size) * vec3(brick)), p_local - cell,
                      reference.w);
}

// Value minus iso [world].
float field_value(vec3 p_local) {
    BrickPoint p = find_brick(p_local);
    if (p.constant != 0.0) return p.constant;
    return tricubic_value(t_atlas, u_atlas_scale, p.corner, p.fraction);
}

// Gradient [world/voxel], index space; zero where no brick is stored.
vec3 field_gradient(vec3 p_local) {
    BrickPoint p = find_brick(p_local);
    if (p.constant != 0.0) return vec3(0.0);
    return tricubic_gradient(t_atlas, u_atlas_scale, p.corner, p.fraction);
}
