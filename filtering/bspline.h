// The uniform cubic B-spline: weights and their derivatives (thesis chapter 5).
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

} // namespace isocast
