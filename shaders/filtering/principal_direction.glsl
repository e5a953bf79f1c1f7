// The direction in which the isosurface through a point has a principal curvature.
// SPDX-License-Identifier: MPL-2.0
// source  thesis eq. 6.8, from the longer of two rows, since one of them vanishes where the first
//         tangent is principal
// twin    filtering/curvature.cpp
#include "filtering/curvature.glsl"

// Unit length; at an umbilic any tangent.
vec3 principal_direction(ShapeOperator s, float k) {
    vec2 row1 = vec2(s.uv, k - s.uu);
    vec2 row2 = vec2(k - s.vv, s.uv);
    vec2 along = dot(row1, row1) > dot(row2, row2) ? row1 : row2;
    float length_squared = dot(along, along);
    along = length_squared > 0.0 ? along * inversesqrt(length_squared) : vec2(1.0, 0.0);
    return along.x * s.u + along.y * s.v;
}
