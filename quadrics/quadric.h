// Rays against the primitives, and the derivatives of what they hit.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"
#include "quadrics/ray_quadric.h"

namespace isocast {

/// A primitive as its form in local coordinates about its own centre, where it has size 1.
struct Quadric {
    QuadricKind kind = QuadricKind::Ball;
    Vec3d anchor_world = Vec3d::Zero(); // as it was given, not rounded
    Vec3d centre_from_anchor = Vec3d::Zero();
    Mat3d local_from_world = Mat3d::Identity(); // q = local_from_world (p - centre)
    double radius_middle = 1;                   // the rest is as in SeenQuadric
    double radius_slope = 0;
    std::array<bool, 2> has_cap{};
    Mat3d a = Mat3d::Identity();
    Vec3d b = Vec3d::Zero();
    double c = -1;
};

/// accuracy  local_from_world is inverted axes, never a product of a matrix and its transpose, from
///           which an ellipsoid of 1 : 1 : 1e-6 could not be told again
/// source    Sigg et al. 2006 eqs 1 and 2: local coordinates are their parameter space, but a cone
///           has its axis along z and its own radii, and general quadrics keep their coefficients,
///           since an affine map of a diagonal form gives no paraboloids
Quadric quadric_of(const Sphere& sphere);
Quadric quadric_of(const Ellipsoid& ellipsoid);
Quadric quadric_of(const Cylinder& cylinder);
Quadric quadric_of(const Cone& cone);
Quadric quadric_of(const ClippedQuadric& quadric);

/// What first_hit() needs of a quadric for rays from `origin_world`; differences in double, so that
/// the distance of the scene from the origin of the world costs nothing.
template<class Real>
SeenQuadric<Real> seen_from(const Quadric& quadric, const Vec3d& origin_world);
extern template SeenQuadric<float> seen_from(const Quadric&, const Vec3d&);
extern template SeenQuadric<double> seen_from(const Quadric&, const Vec3d&);

using QuadricHit = QuadricHitOf<double>;

/// The first point of a primitive along a ray, with t >= t_near; see first_hit() for the accuracy.
/// Open cylinders and cones and cut ones show their inner side.
///
/// direction_world  any length but 0
/// t_near           in lengths of the direction, >= 0
/// returns          nothing where the ray misses, or runs within the surface
template<class Primitive>
std::optional<QuadricHit> intersect(const Primitive& primitive, const Vec3d& origin_world,
                                    const Vec3d& direction_world, double t_near = 0) {
    return first_hit(seen_from<double>(quadric_of(primitive), origin_world), direction_world,
                     t_near);
}

/// Derivatives of a function whose zero set is a primitive, not of a distance: for curvatures.
struct QuadricDerivatives {
    Vec3d gradient; // outwards [1/world]; 0 at a cone's apex
    Mat3d hessian;  // [1/world^2]; constant over a quadric
};

/// At `p_world` on the surface, not on a cap (which is flat).
///
/// accuracy  principal_curvatures() of them within 1e-12 of the greater one: the formulas of a
///           sphere, an ellipsoid, a cylinder and a cone in QuadricDerivatives.*
/// source    Sigg et al. 2006 eq. 9; the Hessian is 2 M^T A M with M = local_from_world
QuadricDerivatives derivatives(const Quadric& quadric, const Vec3d& p_world);
template<class Primitive>
QuadricDerivatives derivatives(const Primitive& primitive, const Vec3d& p_world) {
    return derivatives(quadric_of(primitive), p_world);
}

} // namespace isocast
