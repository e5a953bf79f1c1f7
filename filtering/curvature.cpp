// SPDX-License-Identifier: MPL-2.0
#include "filtering/curvature.h"

#include <cmath>

namespace isocast {

Curvatures principal_curvatures(const Vec3d& gradient, const Mat3d& hessian) {
    const double length = gradient.norm();
    if (!(length > 0)) return {};
    const Vec3d n = gradient / length;
    // Two tangents, orthonormal to rounding whatever the normal: Duff et al., "Building an
    // Orthonormal Basis, Revisited", JCGT 2017.
    const double sign = std::copysign(1.0, n.z());
    const double a = -1 / (sign + n.z());
    const double b = n.x() * n.y() * a;
    const Vec3d u(1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x());
    const Vec3d v(b, sign + n.y() * n.y() * a, -n.y());

    const double uu = u.dot(hessian * u) / length;
    const double uv = u.dot(hessian * v) / length;
    const double vv = v.dot(hessian * v) / length;
    const double root = std::hypot(uu - vv, 2 * uv);
    Curvatures c;
    c.k1 = (uu + vv + root) / 2;
    c.k2 = (uu + vv - root) / 2;
    // Rows of S - k1, turned by a right angle: both are along the direction, and the longer one is
    // the one that did not cancel.
    const Eigen::Vector2d row1(uv, c.k1 - uu);
    const Eigen::Vector2d row2(c.k1 - vv, uv);
    Eigen::Vector2d along = row1.squaredNorm() > row2.squaredNorm() ? row1 : row2;
    along = along.squaredNorm() > 0 ? Eigen::Vector2d(along.normalized()) : Eigen::Vector2d(1, 0);
    c.direction1 = along.x() * u + along.y() * v;
    c.direction2 = n.cross(c.direction1);
    return c;
}

double normal_curvature(const Vec3d& gradient, const Mat3d& hessian, const Vec3d& direction) {
    const double length = gradient.norm();
    if (!(length > 0)) return 0;
    const Vec3d n = gradient / length;
    const Vec3d t = direction - direction.dot(n) * n;
    const double tt = t.squaredNorm();
    return tt > 0 ? t.dot(hessian * t) / (tt * length) : 0;
}

double flow_line_curvature(const Vec3d& gradient, const Mat3d& hessian) {
    const double length = gradient.norm();
    if (!(length > 0)) return 0;
    const Vec3d n = gradient / length;
    const Vec3d along = hessian * n;
    return (along - along.dot(n) * n).norm() / length;
}

} // namespace isocast
