// Which part of the picture a primitive can cover: the rectangles that are drawn for it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"

#include <algorithm>
#include <cmath>

namespace isocast {

/// How points come to the plane of the picture: perspective by slope, (x, y) / -z in view space;
/// orthographic by (x, y) [world]. A camera without the sides of its picture.
struct PictureSpace {
    Vec3d eye_world = Vec3d::Zero();
    Mat3d view_from_world = Mat3d::Identity(); // rows: right, up, back; orthonormal
    bool is_perspective = true;
};

/// What of the plane of the picture can be covered.
enum class ScreenExtent {
    Nothing,    // all of it is behind the eye, or there are no points at all
    Rectangle,  // all of it is in front
    Everything, // it reaches from in front of the eye to behind
};

/// A rectangle with one side along `axis`, the other along that turned left by 90 degrees.
template<class Real>
struct ScreenBoundsOf {
    using Vector = Eigen::Vector2<Real>;
    ScreenExtent extent = ScreenExtent::Nothing;
    Vector axis = Vector(1, 0); // unit
    Vector lo = Vector::Zero(); // along both sides, from the middle of the picture
    Vector hi = Vector::Zero();

    Vector other_axis() const { return {-axis.y(), axis.x()}; }
    Vector corner(int i) const {
        return axis * (i & 1 ? hi : lo).x() + other_axis() * (i & 2 ? hi : lo).y();
    }
    Real area() const { return (hi - lo).prod(); }
};
using ScreenBounds = ScreenBoundsOf<double>;

/// Bounds of all that rays from the picture can hit of a primitive, caps included.
///
/// returns   Rectangle where all of it is in front of the plane through the eye: spheres and
///           ellipsoids touch all four sides of theirs, which has sides along the picture's, and so
///           do cylinders and cones, with sides along and across the axis; a clipped quadric's is
///           that of the corners of its box, cut with that of the quadric where it is an ellipsoid
/// accuracy  some roundings (float: 3e-7) of the farthest side's place from the picture's middle,
///           whatever the size: ScreenBounds.*; it may lack that much, so that whoever rounds to
///           pixels adds a part of one
/// source    Sigg et al. 2006 eqs 3 - 5 (thesis 7.6 - 7.9); the discriminant as a difference that
///           does not cancel, see extent_along(); discs where they bound by ellipsoids
ScreenBounds screen_bounds(const Sphere& sphere, const PictureSpace& space);
ScreenBounds screen_bounds(const Ellipsoid& ellipsoid, const PictureSpace& space);
ScreenBounds screen_bounds(const Cylinder& cylinder, const PictureSpace& space,
                           bool is_upright = false); // along the picture's sides all the same
ScreenBounds screen_bounds(const Cone& cone, const PictureSpace& space, bool is_upright = false);
ScreenBounds screen_bounds(const ClippedQuadric& quadric, const PictureSpace& space);

// What follows is in view space, in float as in double: the same lines as the vertex shaders'.

/// Whether the points centre + axes s, |s| <= 1, are in front of the eye plane.
template<class Real>
ScreenExtent extent_in_depth(const Eigen::Vector3<Real>& centre, const Eigen::Matrix3<Real>& axes) {
    const Real radius = axes.row(2).norm();
    if (centre.z() - radius >= 0) return ScreenExtent::Nothing;
    return centre.z() + radius < 0 ? ScreenExtent::Rectangle : ScreenExtent::Everything;
}
/// Of two parts together with what lies between them.
inline ScreenExtent joined(ScreenExtent a, ScreenExtent b) {
    return a == b ? a : ScreenExtent::Everything;
}

/// The least and the greatest of n . picture(centre + axes s) over |s| <= 1; all of it in front.
///
/// The roots x of Sigg et al.'s eq. 5, (|m4|^2 - c4^2) x^2 - 2 (m1 m4 - c1 c4) x + |m1|^2 - c1^2,
/// where (m1, c1) is the row of n and (m4, c4) that of the depth. Its discriminant as printed is
/// lost for what is small and far; as |c4 m1 - c1 m4|^2 - |m1 x m4|^2 only the smaller square is
/// taken away.
template<class Real>
Eigen::Vector2<Real> extent_along(const Eigen::Vector2<Real>& n, const Eigen::Vector3<Real>& centre,
                                  const Eigen::Matrix3<Real>& axes, bool is_perspective) {
    const Eigen::Vector3<Real> m1 = axes.row(0) * n.x() + axes.row(1) * n.y();
    const Real c1 = n.dot(centre.template head<2>());
    if (!is_perspective) return {c1 - m1.norm(), c1 + m1.norm()};
    const Eigen::Vector3<Real> m4 = -axes.row(2);
    const Real c4 = -centre.z();
    const Real discriminant = (c4 * m1 - c1 * m4).squaredNorm() - m1.cross(m4).squaredNorm();
    const Real root = std::sqrt(std::max(discriminant, Real(0)));
    const Real middle = c1 * c4 - m1.dot(m4);
    const Real radius4 = m4.norm();
    const Real denominator = (c4 - radius4) * (c4 + radius4);
    return {(middle - root) / denominator, (middle + root) / denominator};
}

/// Of the ellipsoid centre + axes s, |s| <= 1.
template<class Real>
ScreenBoundsOf<Real> ellipsoid_bounds(const Eigen::Vector3<Real>& centre,
                                      const Eigen::Matrix3<Real>& axes, bool is_perspective) {
    using Vector2 = Eigen::Vector2<Real>;
    ScreenBoundsOf<Real> bounds{.extent = extent_in_depth(centre, axes)};
    if (bounds.extent == ScreenExtent::Everything && !is_perspective)
        bounds.extent = ScreenExtent::Rectangle;
    if (bounds.extent != ScreenExtent::Rectangle) return bounds;
    const Vector2 x = extent_along(Vector2(1, 0), centre, axes, is_perspective);
    const Vector2 y = extent_along(Vector2(0, 1), centre, axes, is_perspective);
    bounds.lo = {x[0], y[0]};
    bounds.hi = {x[1], y[1]};
    return bounds;
}

/// Of what lies between the disc of `radius_a` about `a` and that about `b`, both across a b.
template<class Real>
ScreenBoundsOf<Real> cone_bounds(const Eigen::Vector3<Real>& a, const Eigen::Vector3<Real>& b,
                                 Real radius_a, Real radius_b, bool is_perspective,
                                 bool is_upright = false) {
    using Vector2 = Eigen::Vector2<Real>;
    using Matrix3 = Eigen::Matrix3<Real>;
    const Eigen::Vector3<Real> d = b - a;
    Matrix3 disc;
    disc.col(0) = d.unitOrthogonal();
    disc.col(1) = d.normalized().cross(disc.col(0));
    disc.col(2).setZero();
    const Matrix3 disc_a = disc * radius_a;
    const Matrix3 disc_b = disc * radius_b;

    ScreenBoundsOf<Real> bounds{.extent =
                                    joined(extent_in_depth(a, disc_a), extent_in_depth(b, disc_b))};
    if (bounds.extent == ScreenExtent::Everything && !is_perspective)
        bounds.extent = ScreenExtent::Rectangle;
    if (bounds.extent != ScreenExtent::Rectangle) return bounds;
    // b's slope less a's, times both depths: the difference of slopes would cancel.
    Vector2 axis = d.template head<2>();
    if (is_perspective) axis = (a.template head<2>() * d.z() - axis * a.z()).eval();
    if (const Real length = axis.norm(); length > 0 && !is_upright) bounds.axis = axis / length;
    const auto along = [&](const Vector2& n) {
        const Vector2 of_a = extent_along(n, a, disc_a, is_perspective);
        const Vector2 of_b = extent_along(n, b, disc_b, is_perspective);
        return Vector2(std::min(of_a[0], of_b[0]), std::max(of_a[1], of_b[1]));
    };
    const Vector2 x = along(bounds.axis);
    const Vector2 y = along(bounds.other_axis());
    bounds.lo = {x[0], y[0]};
    bounds.hi = {x[1], y[1]};
    return bounds;
}

/// Of the box centre + axes s, |s_i| <= 1: of its corners.
template<class Real>
ScreenBoundsOf<Real> box_bounds(const Eigen::Vector3<Real>& centre,
                                const Eigen::Matrix3<Real>& axes, bool is_perspective) {
    using Vector2 = Eigen::Vector2<Real>;
    ScreenBoundsOf<Real> bounds;
    for (int i = 0; i < 8; ++i) {
        const Eigen::Vector3<Real> p =
            centre + axes * Eigen::Vector3<Real>(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
        const ScreenExtent extent = p.z() < 0 ? ScreenExtent::Rectangle : ScreenExtent::Nothing;
        bounds.extent = i == 0 ? extent : joined(bounds.extent, extent);
        const Vector2 at =
            is_perspective ? Vector2(p.template head<2>() / -p.z()) : Vector2(p.template head<2>());
        bounds.lo = i == 0 ? at : Vector2(bounds.lo.cwiseMin(at));
        bounds.hi = i == 0 ? at : Vector2(bounds.hi.cwiseMax(at));
    }
    if (bounds.extent == ScreenExtent::Everything && !is_perspective)
        bounds.extent = ScreenExtent::Rectangle;
    if (bounds.extent != ScreenExtent::Rectangle) bounds = {.extent = bounds.extent};
    return bounds;
}

} // namespace isocast
