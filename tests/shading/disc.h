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

/// Ray i of n into the sky above a surface of that unit normal, as
/// shaders/shading/occlusion/sky.glsl has them.
///
/// source  tangents: Duff et al., JCGT 2017
inline Eigen::Vector3d sky_direction(int i, int n, double turns, const Eigen::Vector3d& normal) {
    const double s = normal.z() < 0 ? -1 : 1;
    const double a = -1 / (s + normal.z());
    const double b = normal.x() * normal.y() * a;
    const Eigen::Vector3d u(1 + s * normal.x() * normal.x() * a, s * b, -s * normal.x());
    const Eigen::Vector3d v(b, s + normal.y() * normal.y() * a, -normal.y());
    const Eigen::Vector2d q = disc_point(i, n, turns);
    return q.x() * u + q.y() * v + std::sqrt(1 - q.squaredNorm()) * normal;
}

} // namespace isocast::test
