// Tricubic B-spline value and gradient from a texture with linear filtering: 8 fetches each
// (thesis eqs 5.5-5.7, section 5.3).
// SPDX-License-Identifier: MPL-2.0
// twin      filtering/reconstruct.cpp
// accuracy  tests/shaders: Tricubic.ValueAgreesWithTheDoubleTwin
#include "filtering/bspline.glsl"

// Sum of 8 linear fetches. `corner` is the texel index of sample i, `scale` 1 / texture size.
float eight_fetches(sampler3D samples, vec3 scale, vec3 corner, LinearPair x, LinearPair y,
                    LinearPair z) {
    // Sample i has its texel centre at i + 1/2.
    vec3 lo = (corner + 0.5 + vec3(x.offset.x, y.offset.x, z.offset.x)) * scale;
    vec3 hi = (corner + 0.5 + vec3(x.offset.y, y.offset.y, z.offset.y)) * scale;
    float v00 = x.weight.x * textureLod(samples, vec3(lo.x, lo.y, lo.z), 0.0).r +
                x.weight.y * textureLod(samples, vec3(hi.x, lo.y, lo.z), 0.0).r;
    float v10 = x.weight.x * textureLod(samples, vec3(lo.x, hi.y, lo.z), 0.0).r +
                x.weight.y * textureLod(samples, vec3(hi.x, hi.y, lo.z), 0.0).r;
    float v01 = x.weight.x * textureLod(samples, vec3(lo.x, lo.y, hi.z), 0.0).r +
                x.weight.y * textureLod(samples, vec3(hi.x, lo.y, hi.z), 0.0).r;
    float v11 = x.weight.x * textureLod(samples, vec3(lo.x, hi.y, hi.z), 0.0).r +
                x.weight.y * textureLod(samples, vec3(hi.x, hi.y, hi.z), 0.0).r;
    return z.weight.x * (y.weight.x * v00 + y.weight.y * v10) +
           z.weight.y * (y.weight.x * v01 + y.weight.y * v11);
}

// Value at corner + a, 0 <= a <= 1.
float tricubic_value(sampler3D samples, vec3 scale, vec3 corner, vec3 a) {
    return eight_fetches(samples, scale, corner, linear_pair(bspline_weights(a.x)),
                         linear_pair(bspline_weights(a.y)), linear_pair(bspline_weights(a.z)));
}

// Gradient at corner + a [1/voxel].
vec3 tricubic_gradient(sampler3D samples, vec3 scale, vec3 corner, vec3 a) {
    LinearPair x = linear_pair(bspline_weights(a.x));
    LinearPair y = linear_pair(bspline_weights(a.y));
    LinearPair z = linear_pair(bspline_weights(a.z));
    return vec3(
        eight_fetches(samples, scale, corner, linear_pair(bspline_weights_d1(a.x)), y, z),
        eight_fetches(samples, scale, corner, x, linear_pair(bspline_weights_d1(a.y)), z),
        eight_fetches(samples, scale, corner, x, y, linear_pair(bspline_weights_d1(a.z))));
}
