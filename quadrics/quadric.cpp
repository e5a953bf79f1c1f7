// SPDX-License-Identifier: MPL-2.0
#include "quadrics/quadric.h"

namespace isocast {

namespace {

/// Local z from -1 at `a_world` to 1 at `b_world`; x and y in units of the greater radius.
Quadric cone_of(const Vec3d& a_world, const Vec3d& b_world, double radius_a, double radius_b,
                bool is_capped) {
    const Vec3d half_axis = (b_world - a_world) / 2;
    const double half_length = half_axis.stableNorm();
    const Vec3d axis = half_axis / half_length;
    const Vec3d u = axis.unitOrthogonal();
    const double radius = std::max(radius_a, radius_b);

    Quadric cone;
    cone.kind = QuadricKind::Cone;
    cone.anchor_world = a_world;
    cone.centre_from_anchor = half_axis;
    cone.local_from_world.row(0) = u / radius;
    cone.local_from_world.row(1) = axis.cross(u) / radius;
    cone.local_from_world.row(2) = axis / half_length;
    cone.radius_middle = (radius_a + radius_b) / 2 / radius;
    cone.radius_slope = (radius_b - radius_a) / 2 / radius;
    cone.has_cap = {is_capped && radius_a > 0, is_capped && radius_b > 0};
    cone.a = Vec3d(1, 1, -cone.radius_slope * cone.radius_slope).asDiagonal();
    cone.b = Vec3d(0, 0, -cone.radius_middle * cone.radius_slope);
    return cone;
}

} // namespace

Quadric quadric_of(const Sphere& sphere) {
    return {.anchor_world = sphere.centre_world,
            .local_from_world = Mat3d::Identity() / sphere.radius_world};
}

Quadric quadric_of(const Ellipsoid& ellipsoid) {
    return {.anchor_world = ellipsoid.centre_world,
            .local_from_world = ellipsoid.axes_world.inverse()};
}

Quadric quadric_of(const Cylinder& cylinder) {
    return cone_of(cylinder.a_world, cylinder.b_world, cylinder.radius_world, cylinder.radius_world,
                   cylinder.is_capped);
}

Quadric quadric_of(const Cone& cone) {
    return cone_of(cone.a_world, cone.b_world, cone.radius_a_world, cone.radius_b_world,
                   cone.is_capped);
}

Quadric quadric_of(const ClippedQuadric& quadric) {
    return {.kind = QuadricKind::General,
            .anchor_world = quadric.centre_world,
            .local_from_world = quadric.axes_world.inverse(),
            .a = quadric.a,
            .b = quadric.b,
            .c = quadric.c};
}

template<class Real>
SeenQuadric<Real> seen_from(const Quadric& quadric, const Vec3d& origin_world) {
    SeenQuadric<double> seen;
    seen.kind = quadric.kind;
    seen.centre = (quadric.anchor_world - origin_world) + quadric.centre_from_anchor;
    seen.local_from_world = quadric.local_from_world;
    seen.radius_middle = quadric.radius_middle;
    seen.radius_slope = quadric.radius_slope;
    seen.has_cap = quadric.has_cap;
    seen.a = quadric.a;
    seen.b = quadric.b;
    seen.c = quadric.c;
    const Vec3d origin_local = -(quadric.local_from_world * seen.centre);
    seen.value_at_origin = along_ray(seen, origin_local, Vec3d(Vec3d::Zero())).gamma;
    // Within 4 sizes: cones and general quadrics lose |origin_local| of their digits when counted
    // from there, while counting from the middle loses nothing once the surface is that far.
    seen.is_near = origin_local.squaredNorm() <= 16;

    SeenQuadric<Real> rounded;
    rounded.kind = seen.kind;
    rounded.centre = seen.centre.cast<Real>();
    rounded.local_from_world = seen.local_from_world.cast<Real>();
    rounded.radius_middle = Real(seen.radius_middle);
    rounded.radius_slope = Real(seen.radius_slope);
    rounded.has_cap = seen.has_cap;
    rounded.a = seen.a.cast<Real>();
    rounded.b = seen.b.cast<Real>();
    rounded.c = Real(seen.c);
    rounded.value_at_origin = Real(seen.value_at_origin);
    rounded.is_near = seen.is_near;
    return rounded;
}
template SeenQuadric<float> seen_from(const Quadric&, const Vec3d&);
template SeenQuadric<double> seen_from(const Quadric&, const Vec3d&);

QuadricDerivatives derivatives(const Quadric& quadric, const Vec3d& p_world) {
    const Mat3d& m = quadric.local_from_world;
    const Vec3d q = m * (p_world - quadric.anchor_world - quadric.centre_from_anchor);
    return {2 * m.transpose() * (quadric.a * q + quadric.b), 2 * m.transpose() * quadric.a * m};
}

} // namespace isocast
