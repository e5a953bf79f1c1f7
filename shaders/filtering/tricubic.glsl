// Value, slope and gradient of the reconstructed field at a point of a stored cell.
// SPDX-License-Identifier: MPL-2.0
// source    thesis eq. 5.1 and section 5.3
// twin      filtering/reconstruct.cpp
// accuracy  tests/shaders: Tricubic.*
#include "filtering/bspline.glsl"

// FETCH 0, rows: a texel holds the four samples i-1 ... i+2 of its cell along x; 16 fetches.
// FETCH 1, samples: a texel holds one sample; 64 fetches, a quarter of the memory.
// FETCH 2, linear: the same in a 3D texture, which the GL filters: 8 fetches of eight samples where they
//          are exact enough, else 64 of one. An address has 11 bits of x, 11 of y and 9 of z.
#if FETCH == 2
layout(binding = 1) uniform sampler3D t_atlas;
ivec3 texel_of(int address) { return ivec3(address & 2047, address >> 11 & 2047, address >> 22); }
#else
layout(binding = 1) uniform samplerBuffer t_samples;
#endif
// ROW_STRIDE, PLANE_STRIDE: texels from a row to the next along y and along z. Values are in units of
// the stored samples, which are world units times a power of two; SAMPLE_ZERO is what stands for 0.

// The samples i-1 ... i+2 along x, from the address of sample i-1.
vec4 row_of_four(int address) {
#if FETCH == 0
    return texelFetch(t_samples, address);
#elif FETCH == 1
    return vec4(texelFetch(t_samples, address).r, texelFetch(t_samples, address + 1).r,
                texelFetch(t_samples, address + 2).r, texelFetch(t_samples, address + 3).r);
#elif FETCH == 2
    ivec3 t = texel_of(address);
    return vec4(texelFetch(t_atlas, t, 0).r, texelFetch(t_atlas, t + ivec3(1, 0, 0), 0).r,
                texelFetch(t_atlas, t + ivec3(2, 0, 0), 0).r,
                texelFetch(t_atlas, t + ivec3(3, 0, 0), 0).r);
#else
#error unknown FETCH
#endif
}

// Value minus iso, and its derivative along d [1/cell], in stored units.
//
// address  of the sample (i-1, j-1, k-1), where (i, j, k) is the cell
// a        where the point lies in the cell, in [0, 1]
vec2 tricubic_value_and_slope(int address, vec3 a, vec3 d) {
    vec4 wx = kernel_weights(a.x);
    vec4 wy = kernel_weights(a.y);
    vec4 wz = kernel_weights(a.z);
    vec4 dx = d.x * kernel_weights_d1(a.x);
    vec4 dy = d.y * kernel_weights_d1(a.y);
    vec4 dz = d.z * kernel_weights_d1(a.z);
    float value = 0.0;
    float slope = 0.0;
    for (int k = first_row; k < last_row; ++k) {
        float plane_value = 0.0;
        float plane_slope = 0.0;
        for (int j = first_row; j < last_row; ++j) {
            vec4 row = row_of_four(address + j * ROW_STRIDE + k * PLANE_STRIDE);
            float along_x = dot(wx, row);
            plane_value += wy[j] * along_x;
            plane_slope += wy[j] * dot(dx, row) + dy[j] * along_x;
        }
        value += wz[k] * plane_value;
        slope += wz[k] * plane_slope + dz[k] * plane_value;
    }
    return vec2(value - SAMPLE_ZERO, slope);
}

// Weights along each axis, and those of first derivatives [1/cell].
struct Weights {
    vec4 x, y, z;
    vec4 dx, dy, dz;
};

Weights weights_at(vec3 a) {
    return Weights(kernel_weights(a.x), kernel_weights(a.y), kernel_weights(a.z),
                   kernel_weights_d1(a.x), kernel_weights_d1(a.y), kernel_weights_d1(a.z));
}

// Gradient [stored units/cell].
vec3 tricubic_gradient(int address, vec3 a) {
    Weights w = weights_at(a);
    vec3 gradient = vec3(0.0);
    for (int k = first_row; k < last_row; ++k) {
        vec3 plane = vec3(0.0); // d/dx, d/dy, value
        for (int j = first_row; j < last_row; ++j) {
            vec4 row = row_of_four(address + j * ROW_STRIDE + k * PLANE_STRIDE);
            float along_x = dot(w.x, row);
            plane += vec3(w.y[j] * dot(w.dx, row), w.dy[j] * along_x, w.y[j] * along_x);
        }
        gradient += vec3(w.z[k], w.z[k], w.dz[k]) * plane;
    }
    return gradient;
}

// First and second derivatives.
struct Derivatives {
    vec3 gradient; // [stored units/cell]
    mat3 hessian;  // [stored units/cell^2]
    float greatest; // |sample| of those that these are sums of [stored units]
};

Derivatives tricubic_derivatives(int address, vec3 a) {
    Weights w = weights_at(a);
    vec4 ddx = kernel_weights_d2(a.x);
    vec4 ddy = kernel_weights_d2(a.y);
    vec4 ddz = kernel_weights_d2(a.z);
    vec3 gradient = vec3(0.0);
    vec3 pure = vec3(0.0);  // xx, yy, zz
    vec3 mixed = vec3(0.0); // yz, xz, xy
    vec4 greatest = vec4(0.0);
    for (int k = first_row; k < last_row; ++k) {
        vec3 plane = vec3(0.0);        // x, y, value
        vec3 plane_second = vec3(0.0); // xx, yy, xy
        for (int j = first_row; j < last_row; ++j) {
            vec4 row = row_of_four(address + j * ROW_STRIDE + k * PLANE_STRIDE);
            greatest = max(greatest, abs(row));
            float value = dot(w.x, row);
            float first = dot(w.dx, row);
            plane += vec3(w.y[j] * first, w.dy[j] * value, w.y[j] * value);
            plane_second += vec3(w.y[j] * dot(ddx, row), ddy[j] * value, w.dy[j] * first);
        }
        gradient += vec3(w.z[k], w.z[k], w.dz[k]) * plane;
        pure += vec3(w.z[k] * plane_second.xy, ddz[k] * plane.z);
        mixed += vec3(w.dz[k] * plane.yx, w.z[k] * plane_second.z);
    }
    return Derivatives(gradient, mat3(pure.x, mixed.z, mixed.y, mixed.z, pure.y, mixed.x, mixed.y,
                                      mixed.x, pure.z),
                       max(max(greatest.x, greatest.y), max(greatest.z, greatest.w)));
}

// Value and slope, and gradient, by the fewest fetches, for what may err by fetch_error() of a slope bound [1/cell].
#if FETCH == 2 && KERNEL != 2 // Catmull-Rom's weights have both signs
#include "filtering/linear_fetches.glsl"
#else
vec3 fast_gradient(int address, vec3 a) { return tricubic_gradient(address, a); }
vec2 fast_value_and_slope(int address, vec3 a, vec3 d) {
    return tricubic_value_and_slope(address, a, d);
}
float fetch_error(float slope) { return 0.0; }
#endif
