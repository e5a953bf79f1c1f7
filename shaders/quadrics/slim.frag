// Pieces of SLIM surfaces: the sheet that comes first, then what is summed over its pieces.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "quadrics/splat.glsl"
#include "quadrics/slim.glsl"
#include "quadrics/slim_blend.glsl"

// STAGE: raycaster/slim_passes.cpp, SlimOutput.
flat in vec4 v_splat[FLOATS4 - PLACE4];

#if STAGE == 0
uniform float u_depth_unit; // as in quadrics/splat.frag
layout(location = 0) out vec2 o_nearest; // as FrameImage::SlimNearest
#else
layout(binding = 1) uniform sampler2D t_nearest;
layout(location = 0) out vec4 o_first;
#if STAGE == 2
layout(location = 1) out vec4 o_second;
#endif
#endif

void main() {
    vec2 slope = ray_slope();
    Kept kept = kept_by_planes(slope, ray_start());
    SlimFragment piece = slim_fragment(v_splat, slope, ray_start(), kept.t_near);
    if (piece.t > kept.t_far || piece.t >= nowhere) discard;
    float number = v_splat[2].w; // of its colour
#if STAGE == 0
    float end = piece.t + piece.reach;
    o_nearest = vec2(end, piece.is_outside ? number + 1.0 : -number - 1.0);
    gl_FragDepth = u_depth_unit / end;
#else
    vec2 nearest = texelFetch(t_nearest, ivec2(gl_FragCoord.xy), 0).xy;
    if (abs(nearest.y) != number + 1.0 || piece.t - piece.reach > nearest.x) discard;
#if STAGE == 1
    o_first = slim_sum(nearest, piece.t, piece.half_gradient / piece.slope, slim_weight(piece));
#else
    float weight = slim_weight(piece);
    mat3 bend = slim_matrix(v_splat) * (weight / piece.slope);
    o_first = vec4(bend[0], bend[1].y);
    o_second = vec4(bend[1].z, bend[2].z, 0.0, weight);
#endif
#endif
}
