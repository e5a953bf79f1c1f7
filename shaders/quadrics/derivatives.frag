// Normals of splats, or what follows from their Hessians, at each hit.
// SPDX-License-Identifier: MPL-2.0
#version 450 core
#include "common/pixel.glsl" // before #if, since a file is included once
// ORDER 1: the normal; 2: what follows from the Hessian.
#if ORDER == 2
#include "filtering/second_order.glsl"
#endif
#include "quadrics/splats.glsl"

layout(binding = 0) uniform sampler2D t_hit;
uniform float u_object; // as whose hits splats are written

#if ORDER == 1
out vec4 o_gradient; // world axes; w as FrameImage::Gradient
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (texelFetch(t_hit, pixel, 0).w != u_object) discard;
    Seen seen = seen_splat(int(texelFetch(t_splat, pixel, 0).r) - 1);
    vec3 normal = u_world_from_view * seen.hit.normal;
#if ORDER == 1
    o_gradient = vec4(normal, width_on_picture(seen));
#else
    // 2^-19: as of fields; curvatures follow from about as many roundings.
    float greatest = length(seen.hessian[0]) + length(seen.hessian[1]) + length(seen.hessian[2]);
    mat3 hessian = u_world_from_view * seen.hessian * transpose(u_world_from_view);
    write_second_order(normal, hessian, true, greatest * exp2(-19.0));
#endif
}
