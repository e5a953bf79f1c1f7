// Value, slope and gradient by the GL's own trilinear filter: 8 and 24 fetches of eight samples. Their
// fractions are what the GL makes of them, of 8 bits in hardware: docs/raycasting.md.
// SPDX-License-Identifier: MPL-2.0
// source  thesis eqs 5.4-5.7, 5.9 and section 5.3; not by its listings, which have slips
// twin    filtering/reconstruct.cpp
// Of tricubic.glsl, for kernels whose neighbouring weights have one sign.

#include "filtering/fetches.glsl"

// The first and the last of the four samples stand alone at the cell's ends. 2^-10 from there, so that
// a rounded place does not reach into the next brick.
Fetches fetches_of_slope(float a) {
    Fetches f = pairs_of(kernel_weights_d1(a));
    const float margin = 1.0 / 1024.0;
    return Fetches(clamp(f.at, vec2(margin), vec2(3.0 - margin)), f.weight);
}

// texel  integers are the samples' places
float filtered(vec3 texel) {
#if FRACTION_BITS > 0 // what a filter of so many bits would do, to be measured
    const float steps = float(1 << FRACTION_BITS);
    texel = floor(texel * steps + 0.5) / steps;
#endif
    return textureLod(t_atlas, (texel + 0.5) / vec3(textureSize(t_atlas, 0)), 0.0).r;
}

float sum_of_fetches(vec3 texel, Fetches x, Fetches y, Fetches z, ivec3 n) {
    float sum = 0.0;
    for (int k = 0; k < n.z; ++k)
        for (int j = 0; j < n.y; ++j)
            for (int i = 0; i < n.x; ++i)
                sum += x.weight[i] * y.weight[j] * z.weight[k] *
                       filtered(texel + vec3(x.at[i], y.at[j], z.at[k]));
    return sum;
}

vec3 fast_gradient(int address, vec3 a) {
    vec3 texel = vec3(texel_of(address));
    Fetches x = fetches_of_value(a.x);
    Fetches y = fetches_of_value(a.y);
    Fetches z = fetches_of_value(a.z);
    const int n = value_fetches;
    return vec3(sum_of_fetches(texel, fetches_of_slope(a.x), y, z, ivec3(2, n, n)),
                sum_of_fetches(texel, x, fetches_of_slope(a.y), z, ivec3(n, 2, n)),
                sum_of_fetches(texel, x, y, fetches_of_slope(a.z), ivec3(n, n, 2)));
}

vec2 fast_value_and_slope(int address, vec3 a, vec3 d) {
    float value = sum_of_fetches(vec3(texel_of(address)), fetches_of_value(a.x),
                                 fetches_of_value(a.y), fetches_of_value(a.z), ivec3(value_fetches));
    return vec2(value - SAMPLE_ZERO, dot(d, fast_gradient(address, a)));
}

// Greatest error of fast_value_and_slope().x, and an eighth of that of its slope along a unit vector
// [1/cell], for a slope bound L (docs/raycasting.md: 6 e L).
//
// slope  the certificate's [stored units/cell]
float fetch_error(float slope) {
    ivec3 n = textureSize(t_atlas, 0);
    // Fractions of 8 bits, to the nearest; places in the texture, four roundings of up to 1.
    float e = 1.0 / 512.0 + float(max(n.x, max(n.y, n.z))) / 4194304.0; // 2^22
    return 6.0 * e * slope;
}
