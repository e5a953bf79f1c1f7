// Reconstruction kernels: their four weights per axis and those of their derivatives.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/bspline.h"

namespace isocast {

namespace {

// As for the B-spline, the weights of i+1 and i+2 are mirror images of those of i and i-1.

std::array<double, 4> catmull_rom_weights(double a) {
    const double b = 1 - a;
    return {-a * b * b / 2, b * (2 + a * (2 - 3 * a)) / 2, a * (2 + b * (2 - 3 * b)) / 2,
            -b * a * a / 2};
}

std::array<double, 4> catmull_rom_weights_d1(double a) {
    const double b = 1 - a;
    return {b * (2 - 3 * b) / 2, a * (9 * a - 10) / 2, b * (10 - 9 * b) / 2, a * (3 * a - 2) / 2};
}

std::array<double, 4> catmull_rom_weights_d2(double a) {
    return {2 - 3 * a, 9 * a - 5, 4 - 9 * a, 3 * a - 1};
}

} // namespace

std::array<double, 4> bspline_weights(double a) {
    const double b = 1 - a;
    // w1 and w2 are each other's mirror image; written alike, they are so to the last bit nearly.
    return {b * b * b / 6, ((3 * a - 6) * a * a + 4) / 6, ((3 * b - 6) * b * b + 4) / 6,
            a * a * a / 6};
}

std::array<double, 4> bspline_weights_d1(double a) {
    const double b = 1 - a;
    return {-b * b / 2, (3 * a - 4) * a / 2, (4 - 3 * b) * b / 2, a * a / 2};
}

std::array<double, 4> bspline_weights_d2(double a) {
    return {1 - a, 3 * a - 2, 1 - 3 * a, a};
}

std::array<double, 4> kernel_weights(Kernel kernel, double a) {
    switch (kernel) {
    case Kernel::Linear:
        return {0, 1 - a, a, 0};
    case Kernel::BSpline:
        return bspline_weights(a);
    case Kernel::CatmullRom:
        return catmull_rom_weights(a);
    }
    return {};
}

std::array<double, 4> kernel_weights_d1(Kernel kernel, double a) {
    switch (kernel) {
    case Kernel::Linear:
        return {0, -1, 1, 0};
    case Kernel::BSpline:
        return bspline_weights_d1(a);
    case Kernel::CatmullRom:
        return catmull_rom_weights_d1(a);
    }
    return {};
}

std::array<double, 4> kernel_weights_d2(Kernel kernel, double a) {
    switch (kernel) {
    case Kernel::Linear:
        return {0, 0, 0, 0};
    case Kernel::BSpline:
        return bspline_weights_d2(a);
    case Kernel::CatmullRom:
        return catmull_rom_weights_d2(a);
    }
    return {};
}

} // namespace isocast
