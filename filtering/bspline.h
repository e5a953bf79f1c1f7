// Reconstruction kernels: their four weights per axis and those of their derivatives, the cubic
// B-spline's (thesis chapter 5) first.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <array>

namespace isocast {

/// Weights of the samples i-1, i, i+1, i+2 at the point i + a, 0 <= a <= 1.
/// source  thesis eq. 5.2; w1 is (3a^3 - 6a^2 + 4)/6, printed with -3a^2
/// twin    shaders/filtering/bspline.glsl
std::array<double, 4> bspline_weights(double a);

/// First derivatives of the weights [1/voxel].
/// source  thesis eq. 5.9; w1' is (3a^2 - 4a)/2, printed with -2a
std::array<double, 4> bspline_weights_d1(double a);

/// Second derivatives of the weights [1/voxel^2].
std::array<double, 4> bspline_weights_d2(double a);

/// How control samples become a function: separable, each axis by weights of the four samples
/// i-1, i, i+1, i+2.
enum class Kernel {
    Linear,     // continuous; reads i and i+1 only
    BSpline,    // two continuous derivatives; does not pass through the control samples
    CatmullRom, // one continuous derivative; passes through the control samples
};

/// Whether the kernel's functions have a continuous gradient, so that a bound of their second
/// derivatives holds across cells too.
constexpr bool is_smooth(Kernel kernel) {
    return kernel != Kernel::Linear;
}

/// Weights of the samples i-1, i, i+1, i+2 at the point i + a, 0 <= a <= 1.
/// source  Catmull-Rom: the cubic through samples i and i+1 with half the difference of each
///         one's two neighbours as its slope there
std::array<double, 4> kernel_weights(Kernel kernel, double a);

/// First derivatives of the weights [1/voxel].
std::array<double, 4> kernel_weights_d1(Kernel kernel, double a);

/// Second derivatives of the weights [1/voxel^2]; Catmull-Rom's jump from cell to cell.
std::array<double, 4> kernel_weights_d2(Kernel kernel, double a);

} // namespace isocast
