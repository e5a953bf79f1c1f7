// Superquadrics: bodies between balls, cylinders and boxes, which show tensors without the doubts
// that the outlines of ellipsoids leave.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/point_data.h"
#include "quadrics/quadric.h"
#include "quadrics/ray_superquadric.h"
#include "quadrics/screen_bounds.h"

namespace isocast {

/// The superquadric glyph of a symmetric tensor: semi-axes as of primitives_of(); of an isotropic
/// one a ball, of a linear or planar one a cylinder along its first or third eigenvector, between
/// them boxes.
///
/// look     its sharpness, gamma, is how fast edges grow with anisotropy; 0 leaves ellipsoids
/// returns  nothing for a tensor that is smaller than 1e-30
/// source   Kindlmann 2004, "Superquadric Tensor Glyphs", as its author's Teem has it (ten/glyph.c,
///          ten/aniso.c): c_l = (l1 - l2) / sum, c_p = 2 (l2 - l3) / sum; where c_l >= c_p
///          alpha = (1 - c_p)^gamma and beta = (1 - c_l)^gamma about the first eigenvector, else
///          alpha = (1 - c_l)^gamma and beta = (1 - c_p)^gamma about the third, so that
///          beta <= alpha. Teem keeps c_l and c_p from 1, we alpha and beta from 0, by 0.05; of
///          negative eigenvalues we take the absolute value
std::optional<Superquadric> superquadric_of(const Vec3d& centre_world, const Mat3d& tensor,
                                            const PointLook& look = {});

/// What first_hit() needs for rays from `origin_world`; differences in double.
template<class Real>
SeenSuperquadric<Real> seen_from(const Superquadric& superquadric, const Vec3d& origin_world);
extern template SeenSuperquadric<float> seen_from(const Superquadric&, const Vec3d&);
extern template SeenSuperquadric<double> seen_from(const Superquadric&, const Vec3d&);

/// The first point along a ray, with t >= t_near; see first_hit() for the accuracy.
///
/// direction_world  any length but 0
inline std::optional<QuadricHit> intersect(const Superquadric& superquadric,
                                           const Vec3d& origin_world, const Vec3d& direction_world,
                                           double t_near = 0) {
    return first_hit(seen_from<double>(superquadric, origin_world), direction_world, t_near);
}

/// Of N(q) - 1, at `p_world` on the surface: for curvatures.
///
/// accuracy  against differences of the definition in long double, with size 1: the gradient within
///           1e-12, the Hessian within 1e-9 of the exponent 2 / beta, which is what differences can
///           tell; curvatures of ellipsoids as of quadric.h: SuperquadricDerivatives.*; where there
///           is no Hessian: superquadric_norm_hessian()
QuadricDerivatives derivatives(const Superquadric& superquadric, const Vec3d& p_world);

/// The greatest n . (p - centre) over the body.
///
/// source  the dual norm of axes^T n, see dual()
double support(const Superquadric& superquadric, const Vec3d& n_world);
/// A point that reaches it: its only one, but for the edges and faces of the sharpest.
Vec3d farthest_point(const Superquadric& superquadric, const Vec3d& n_world);

/// Bounds of all that rays from the picture can hit, with sides along the picture's that touch.
///
/// returns   as screen_bounds() of ellipsoids
/// accuracy  1e-14 of the greater side's place from the picture's middle; it may lack that much:
///           SuperquadricBounds.*
ScreenBounds screen_bounds(const Superquadric& superquadric, const PictureSpace& space);

/// The greatest n . picture(p) over the body centre + axes q, N(q) <= 1, in view space; all of it
/// in front of the eye.
///
/// The greatest slope m is where n . p_xy + m p_z, with p_z < 0, has its maximum 0 over the body.
/// That maximum is convex and falling in m, and its tangent at m comes from the body's farthest
/// point in direction (n, m): the next m is that point's slope. So each is the slope of a point of
/// the body and none is too great; they grow until rounding ends that.
template<class Real>
Real greatest_along(const Eigen::Vector2<Real>& n, const Eigen::Vector3<Real>& centre,
                    const Eigen::Matrix3<Real>& axes, const NormExponents<Real>& exponents,
                    bool is_perspective) {
    const NormExponents<Real> of_support = dual(exponents);
    const Real c = n.dot(centre.template head<2>());
    const Eigen::Vector3<Real> along =
        axes.row(0).transpose() * n.x() + axes.row(1).transpose() * n.y();
    if (!is_perspective) return c + superquadric_norm(along, of_support).value;
    const Eigen::Vector3<Real> depth = axes.row(2).transpose();
    Real m = c / -centre.z();
    // 32: Newton's steps, which double the digits but for a start among the edges of boxes, where
    // each passes one; of 1e5 random bodies one took 9, the mean 3.4.
    for (int step = 0; step < 32; ++step) {
        const Eigen::Vector3<Real> q =
            superquadric_norm(Eigen::Vector3<Real>(along + depth * m), of_support).gradient;
        const Real next = (c + along.dot(q)) / -(centre.z() + depth.dot(q));
        if (!(next > m)) break;
        m = next;
    }
    return m;
}

template<class Real>
ScreenBoundsOf<Real>
superquadric_bounds(const Eigen::Vector3<Real>& centre, const Eigen::Matrix3<Real>& axes,
                    const NormExponents<Real>& exponents, bool is_perspective) {
    using Vector2 = Eigen::Vector2<Real>;
    const Real half_depth =
        superquadric_norm(Eigen::Vector3<Real>(axes.row(2)), dual(exponents)).value;
    ScreenBoundsOf<Real> bounds;
    bounds.extent = centre.z() - half_depth >= 0  ? ScreenExtent::Nothing
                    : centre.z() + half_depth < 0 ? ScreenExtent::Rectangle
                                                  : ScreenExtent::Everything;
    if (bounds.extent == ScreenExtent::Everything && !is_perspective)
        bounds.extent = ScreenExtent::Rectangle;
    if (bounds.extent != ScreenExtent::Rectangle) return bounds;
    const auto greatest = [&](Real x, Real y) {
        return greatest_along(Vector2(x, y), centre, axes, exponents, is_perspective);
    };
    bounds.lo = {-greatest(-1, 0), -greatest(0, -1)};
    bounds.hi = {greatest(1, 0), greatest(0, 1)};
    return bounds;
}

} // namespace isocast
