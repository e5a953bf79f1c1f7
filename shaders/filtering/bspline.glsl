// The uniform cubic B-spline's weights, and the two linear fetches that replace four samples.
// SPDX-License-Identifier: MPL-2.0
// source  thesis eqs 5.2, 5.5, 5.6, 5.9 (misprints of w1 and w1' corrected)
// twin    filtering/bspline.cpp

// Weights of the samples i-1, i, i+1, i+2 at i + a, written without cancellation.
vec4 bspline_weights(float a) {
    float b = 1.0 - a;
    return vec4(b * b * b, 4.0 - 3.0 * a * a * (2.0 - a), 4.0 - 3.0 * b * b * (2.0 - b),
                a * a * a) / 6.0;
}

// First derivatives [1/voxel].
vec4 bspline_weights_d1(float a) {
    float b = 1.0 - a;
    return vec4(-0.5 * b * b, a * (1.5 * a - 2.0), b * (2.0 - 1.5 * b), 0.5 * a * a);
}

// Two linear fetches for four weights: at i + offset.x with weight.x, at i + offset.y with
// weight.y. Each pair of weights has one sign, so the fetch lies between its two samples.
struct LinearPair {
    vec2 offset;
    vec2 weight;
};

LinearPair linear_pair(vec4 w) {
    vec2 weight = vec2(w.x + w.y, w.z + w.w);
    // w.x + w.y vanishes nowhere for the value; for the derivative at no a in [0, 1] either:
    // -(1 + 2a - 2a^2)/2.
    return LinearPair(vec2(-1.0 + w.y / weight.x, 1.0 + w.w / weight.y), weight);
}
