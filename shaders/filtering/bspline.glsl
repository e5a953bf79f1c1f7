// The weights of the reconstruction kernels.
// SPDX-License-Identifier: MPL-2.0
// source  thesis eqs 5.2, 5.9 (misprints of w1 and w1' corrected)
// twin    filtering/bspline.cpp
//
// KERNEL 0: linear, 1: cubic B-spline, 2: Catmull-Rom.

// Weights of the samples i-1, i, i+1, i+2 at i + a, written without cancellation.
vec4 kernel_weights(float a) {
    float b = 1.0 - a;
#if KERNEL == 0
    return vec4(0.0, b, a, 0.0);
#elif KERNEL == 1
    return vec4(b * b * b, 4.0 - 3.0 * a * a * (2.0 - a), 4.0 - 3.0 * b * b * (2.0 - b),
                a * a * a) / 6.0;
#elif KERNEL == 2
    return 0.5 * vec4(-a * b * b, 2.0 - a * a * (5.0 - 3.0 * a), 2.0 - b * b * (5.0 - 3.0 * b),
                      -b * a * a);
#else
#error unknown KERNEL
#endif
}

// First derivatives [1/voxel].
vec4 kernel_weights_d1(float a) {
    float b = 1.0 - a;
#if KERNEL == 0
    return vec4(0.0, -1.0, 1.0, 0.0);
#elif KERNEL == 1
    return vec4(-0.5 * b * b, a * (1.5 * a - 2.0), b * (2.0 - 1.5 * b), 0.5 * a * a);
#else
    return 0.5 * vec4(b * (2.0 * a - b), a * (9.0 * a - 10.0), b * (10.0 - 9.0 * b),
                      a * (a - 2.0 * b));
#endif
}

// Second derivatives [1/voxel^2]; Catmull-Rom's jump from cell to cell.
vec4 kernel_weights_d2(float a) {
    float b = 1.0 - a;
#if KERNEL == 0
    return vec4(0.0);
#elif KERNEL == 1
    return vec4(b, 3.0 * a - 2.0, 1.0 - 3.0 * a, a);
#else
    return vec4(2.0 - 3.0 * a, 9.0 * a - 5.0, 4.0 - 9.0 * a, 3.0 * a - 1.0);
#endif
}

// The rows of samples along y and z that have weight: first and one past the last of the four.
#if KERNEL == 0
const int first_row = 1;
const int last_row = 3;
#else
const int first_row = 0;
const int last_row = 4;
#endif
