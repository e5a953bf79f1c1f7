// The kernel's four weights along an axis as two fetches of two samples each.
// SPDX-License-Identifier: MPL-2.0
// source  thesis eqs 5.4-5.7; not by its listings, which have slips
// For kernels whose neighbouring weights have one sign.
#include "filtering/bspline.glsl"

// Along an axis: where the fetches are taken, from sample i-1 on, and their weights.
struct Fetches {
    vec2 at;
    vec2 weight;
};

// Eq. 5.4 of samples i-1 and i, and of i+1 and i+2.
Fetches pairs_of(vec4 w) {
    vec2 sum = w.xz + w.yw;
    return Fetches(vec2(0.0, 2.0) + w.yw / sum, sum);
}

#if KERNEL == 0
const int value_fetches = 1; // along an axis: the filter is the kernel
Fetches fetches_of_value(float a) { return Fetches(vec2(1.0 + a, 0.0), vec2(1.0, 0.0)); }
#else
const int value_fetches = 2;
Fetches fetches_of_value(float a) { return pairs_of(kernel_weights(a)); }
#endif
