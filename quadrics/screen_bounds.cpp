// SPDX-License-Identifier: MPL-2.0
#include "quadrics/screen_bounds.h"

#include <Eigen/Cholesky>

#include <optional>

namespace isocast {

namespace {

Vec3d in_view(const PictureSpace& space, const Vec3d& p_world) {
    return space.view_from_world * (p_world - space.eye_world);
}

/// Points p = centre + axes s, |s| <= 1 [world].
struct Ellipsoidal {
    Vec3d centre_world;
    Mat3d axes_world;
    bool is_empty;
};

/// The quadric without its box, if it is an ellipsoid.
std::optional<Ellipsoidal> ellipsoid_of(const ClippedQuadric& quadric) {
    const double sign = quadric.a.trace() < 0 ? -1 : 1;
    const Eigen::LLT<Mat3d> llt(sign * quadric.a); // sign A = L L^T
    const Mat3d l = llt.matrixL();
    // 1e-3: one that is a million times as long as it is thick is cut by its box anyway, and below
    // that its place is known to 1e-10 of its length.
    if (llt.info() != Eigen::Success || l.diagonal().minCoeff() < 1e-3 * l.diagonal().maxCoeff())
        return {};
    const Vec3d middle = -llt.solve(sign * quadric.b);
    const double value = sign * (quadric.c + quadric.b.dot(middle));
    // (q - middle)^T L L^T (q - middle) = -value
    const Mat3d axes = l.transpose().inverse() * std::sqrt(std::max(-value, 0.0));
    return Ellipsoidal{quadric.centre_world + quadric.axes_world * middle,
                       quadric.axes_world * axes, value > 0};
}

} // namespace

ScreenBounds screen_bounds(const Sphere& sphere, const PictureSpace& space) {
    // A sphere is its own image by any rotation: without that of the view its axes keep zeros.
    return ellipsoid_bounds<double>(in_view(space, sphere.centre_world),
                                    Mat3d::Identity() * sphere.radius_world, space.is_perspective);
}

ScreenBounds screen_bounds(const Ellipsoid& ellipsoid, const PictureSpace& space) {
    return ellipsoid_bounds<double>(in_view(space, ellipsoid.centre_world),
                                    space.view_from_world * ellipsoid.axes_world,
                                    space.is_perspective);
}

ScreenBounds screen_bounds(const Cylinder& cylinder, const PictureSpace& space, bool is_upright) {
    return cone_bounds<double>(in_view(space, cylinder.a_world), in_view(space, cylinder.b_world),
                               cylinder.radius_world, cylinder.radius_world, space.is_perspective,
                               is_upright);
}

ScreenBounds screen_bounds(const Cone& cone, const PictureSpace& space, bool is_upright) {
    return cone_bounds<double>(in_view(space, cone.a_world), in_view(space, cone.b_world),
                               cone.radius_a_world, cone.radius_b_world, space.is_perspective,
                               is_upright);
}

ScreenBounds screen_bounds(const ClippedQuadric& quadric, const PictureSpace& space) {
    ScreenBounds box =
        box_bounds<double>(in_view(space, quadric.centre_world),
                           space.view_from_world * quadric.axes_world, space.is_perspective);
    const std::optional<Ellipsoidal> ellipsoid = ellipsoid_of(quadric);
    if (!ellipsoid || box.extent == ScreenExtent::Nothing) return box;
    if (ellipsoid->is_empty) return {};
    const ScreenBounds whole = ellipsoid_bounds<double>(
        in_view(space, ellipsoid->centre_world), space.view_from_world * ellipsoid->axes_world,
        space.is_perspective);
    if (whole.extent == ScreenExtent::Everything) return box;
    if (whole.extent == ScreenExtent::Nothing || box.extent == ScreenExtent::Everything)
        return whole;
    box.lo = box.lo.cwiseMax(whole.lo);
    box.hi = box.hi.cwiseMin(whole.hi);
    if ((box.lo.array() > box.hi.array()).any()) return {};
    return box;
}

} // namespace isocast
