// The points of shaders/shading/disc.glsl, in double.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <numbers>

namespace isocast::test {

inline Eigen::Vector2d disc_point(int i, int n, double turns) {
    const double angle = 2 * std::numbers::pi * (0.61803398875 * i + turns);
    return std::sqrt((i + 0.5) / n) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

/// x, y  gl_FragCoord
inline double turns_of_pixel(double x, double y) {
    return 0.75487766625 * x + 0.56984029100 * y;
}

} // namespace isocast::test
