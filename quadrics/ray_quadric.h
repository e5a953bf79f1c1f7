// Where a ray first meets a quadric, in float as in double: the same lines as the shader's.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace isocast {

/// Which form f(q) takes in a quadric's local coordinates q; inside is negative.
enum class QuadricKind {
    Ball,    // |q|^2 - 1
    Cone,    // q_x^2 + q_y^2 - r(q_z)^2 where |q_z| <= 1, r(z) = radius_middle + radius_slope z
    General, // q^T a q + 2 b^T q + c where |q_x|, |q_y|, |q_z| <= 1
};

/// A quadric as seen from where rays start; made in double by seen_from(), then rounded to Real.
template<class Real>
struct SeenQuadric {
    QuadricKind kind = QuadricKind::Ball;
    Eigen::Vector3<Real> centre;           // from the origin of rays [world]
    Eigen::Matrix3<Real> local_from_world; // linear part: q = local_from_world (p - centre)
    Real radius_middle = 1;                // of cones, in local coordinates
    Real radius_slope = 0;
    std::array<bool, 2> has_cap{}; // of cones: the disc at q_z = -1, at q_z = 1
    Eigen::Matrix3<Real> a;        // of general ones
    Eigen::Vector3<Real> b;
    Real c = 0;
    Real value_at_origin = 0; // f there, which a float could not tell from 0 near the surface
    bool is_near = false;     // the origin is so close that roots are counted from it
};

/// Where a ray meets a quadric: the surface within its clip, or a cap.
template<class Real>
struct QuadricHitOf {
    Real t = 0;                  // p = origin + t direction
    Eigen::Vector3<Real> normal; // unit, outwards [world]; against the ray at a cone's apex
    bool is_inside = false;      // the ray meets the inner side
    int cap = 0;                 // 0: the surface; 1: the disc at the first end; 2: the other
};

/// f along a ray from the local point p along k: alpha s^2 + 2 beta s + gamma.
template<class Real>
struct QuadraticOf {
    Real alpha = 0;
    Real beta = 0;
    Real gamma = 0;
};

template<class Real>
QuadraticOf<Real> along_ray(const SeenQuadric<Real>& quadric, const Eigen::Vector3<Real>& p,
                            const Eigen::Vector3<Real>& k) {
    switch (quadric.kind) {
    case QuadricKind::Ball:
        return {k.dot(k), k.dot(p), p.dot(p) - 1};
    case QuadricKind::Cone: {
        // A difference of squares as a product, so that it keeps its digits along the sides.
        const Real r = quadric.radius_middle + quadric.radius_slope * p.z();
        const Real k_r = quadric.radius_slope * k.z();
        const Real k_xy = std::hypot(k.x(), k.y());
        const Real p_xy = std::hypot(p.x(), p.y());
        return {(k_xy - k_r) * (k_xy + k_r), k.x() * p.x() + k.y() * p.y() - k_r * r,
                (p_xy - r) * (p_xy + r)};
    }
    case QuadricKind::General:
        break;
    }
    const Eigen::Vector3<Real> a_p = quadric.a * p;
    return {k.dot(quadric.a * k), k.dot(a_p + quadric.b), p.dot(a_p + 2 * quadric.b) + quadric.c};
}

/// Half the gradient of f at the local point q.
template<class Real>
Eigen::Vector3<Real> half_gradient(const SeenQuadric<Real>& quadric,
                                   const Eigen::Vector3<Real>& q) {
    switch (quadric.kind) {
    case QuadricKind::Ball:
        return q;
    case QuadricKind::Cone: {
        const Real r = quadric.radius_middle + quadric.radius_slope * q.z();
        return {q.x(), q.y(), -quadric.radius_slope * r};
    }
    case QuadricKind::General:
        break;
    }
    return quadric.a * q + quadric.b;
}

/// The roots of alpha s^2 + 2 beta s + gamma, the lesser one first. Where alpha is 0 one of them is
/// infinite, and where nothing depends on s they are infinite or NaN: no interval holds those.
///
/// discriminant  beta^2 - alpha gamma, which does not depend on where s is counted from; >= 0
template<class Real>
std::array<Real, 2> stable_roots(const QuadraticOf<Real>& f, Real discriminant) {
    const Real root = std::sqrt(discriminant);
    const Real q = -(f.beta + (f.beta < 0 ? -root : root)); // no sign(): that of 0 must not be 0
    const Real s1 = f.gamma / q;
    const Real s2 = q / f.alpha;
    return s1 <= s2 ? std::array{s1, s2} : std::array{s2, s1};
}

/// The part of the ray p + s k where |q_i| <= 1; empty if from > to.
template<class Real>
struct RayInterval {
    Real from = -std::numeric_limits<Real>::infinity();
    Real to = std::numeric_limits<Real>::infinity();
};
template<class Real>
RayInterval<Real> within_slab(Real p, Real k) {
    constexpr Real infinity = std::numeric_limits<Real>::infinity();
    if (k == 0)
        return std::abs(p) <= 1 ? RayInterval<Real>{} : RayInterval<Real>{infinity, -infinity};
    const Real s1 = (-1 - p) / k;
    const Real s2 = (1 - p) / k;
    return {std::min(s1, s2), std::max(s1, s2)};
}

/// Where a ray comes closest to the centre of a quadric.
template<class Real>
struct ClosestApproach {
    Real t = 0;
    Eigen::Vector3<Real> y; // from the centre
};

template<class Real>
ClosestApproach<Real> closest_approach(const Eigen::Vector3<Real>& centre,
                                       const Eigen::Vector3<Real>& direction) {
    const Real t = direction.dot(centre) / direction.dot(direction);
    return {t, direction * t - centre};
}

/// The same of the view's ray of direction (slope, -1) from the eye, all in view space.
///
/// accuracy  a rounding of the centre's distance from the view's axis, however far it is away: with
///           w from the ray to the centre, across the axis at its depth, y = -w + v (slope w)/v^2,
///           where nothing as long as the distance is taken from anything
template<class Real>
ClosestApproach<Real> closest_approach_in_view(const Eigen::Vector3<Real>& centre,
                                               const Eigen::Vector2<Real>& slope) {
    const Eigen::Vector2<Real> w = centre.template head<2>() + slope * centre.z();
    const Real back = slope.dot(w) / (1 + slope.squaredNorm());
    return {back - centre.z(), {slope.x() * back - w.x(), slope.y() * back - w.y(), -back}};
}

/// The first point of a quadric along a ray, at t >= t_near.
///
/// direction  axes of the quadric's, any length but 0
/// closest    to its centre along the ray
/// t_near     >= 0; what is nearer has been cut off, and one sees what lies behind the cut
/// accuracy   the point lies off the surface by a few roundings of its distance from the origin of
///            rays or of the quadric's size, whichever is greater: QuadricIntersect.*; where the
///            origin is within 4 sizes, of the distance from the origin
/// source     Sigg et al. 2006 eqs 6, 7 and 9 with the ray in world space, not by depth in the
///            window; the discriminant at the closest approach to the centre and the stable roots
///            as in Ray Tracing Gems ch. 7; eq. 7.13 of the thesis takes the smaller root, here it
///            is the first one in front of `t_near` and within the clip
template<class Real>
std::optional<QuadricHitOf<Real>> first_hit(const SeenQuadric<Real>& quadric,
                                            const Eigen::Vector3<Real>& direction,
                                            const ClosestApproach<Real>& closest, Real t_near) {
    using Vector = Eigen::Vector3<Real>;
    // To the point of the ray that is closest to the centre, by world distance and then by local.
    const Vector k = quadric.local_from_world * direction;
    Vector p = quadric.local_from_world * closest.y;
    Real shift = -p.dot(k) / k.dot(k);
    p += k * shift;
    QuadraticOf<Real> f = along_ray(quadric, p, k);
    // Then to where f is extreme, unless that is farther from the centre than the clip (sqrt(3)).
    // The local step has done nearly all: no test here is worse without this one.
    if (std::abs(f.beta) * k.norm() < 2 * std::abs(f.alpha)) {
        const Real to_extremum = -f.beta / f.alpha;
        p += k * to_extremum;
        shift += to_extremum;
        f = along_ray(quadric, p, k);
    }
    const Real discriminant = f.beta * f.beta - f.alpha * f.gamma;
    // From near by, roots are counted from the origin: the other way would swallow the distance to
    // a surface right in front.
    Real t_base = closest.t + shift;
    if (quadric.is_near) {
        t_base = 0;
        p = -(quadric.local_from_world * quadric.centre);
        f = along_ray(quadric, p, k);
        f.gamma = quadric.value_at_origin;
    }
    const bool has_roots = discriminant >= 0;
    const std::array<Real, 2> roots =
        has_roots ? stable_roots(f, discriminant) : std::array<Real, 2>{};

    RayInterval<Real> clip;
    if (quadric.kind != QuadricKind::Ball)
        for (int axis = quadric.kind == QuadricKind::Cone ? 2 : 0; axis < 3; ++axis) {
            const RayInterval<Real> slab = within_slab(p[axis], k[axis]);
            clip.from = std::max(clip.from, slab.from);
            clip.to = std::min(clip.to, slab.to);
        }

    std::optional<QuadricHitOf<Real>> hit;
    const auto is_first = [&](Real t) { return t >= t_near && (!hit || t < hit->t); };
    for (const int i : {0, 1}) {
        const Real s = roots[i];
        if (!has_roots || !(s >= clip.from && s <= clip.to) || !is_first(t_base + s)) continue;
        Vector normal =
            quadric.local_from_world.transpose() * half_gradient(quadric, Vector(p + k * s));
        if (normal.isZero(0)) normal = -direction;
        // The ray leaves where f increases: by the order of the roots, since the normal of a ray
        // that grazes may lean to either side.
        const bool leaves = f.alpha == 0 ? f.beta > 0 : (i == 1) == (f.alpha > 0);
        hit = {t_base + s, normal.normalized(), leaves, 0};
    }
    // Caps are tested by the order of the same roots, not by f: no gap at their rims.
    const auto is_within = [&](Real s) {
        if (f.alpha == 0) return f.gamma + 2 * f.beta * s <= 0;
        if (!has_roots) return f.alpha < 0;
        return f.alpha > 0 ? s >= roots[0] && s <= roots[1] : s <= roots[0] || s >= roots[1];
    };
    for (const int end : {0, 1}) {
        const Real side = end == 0 ? -1 : 1;
        if (!quadric.has_cap[end] || k.z() == 0) continue;
        const Real s = (side - p.z()) / k.z();
        if (!is_first(t_base + s) || !is_within(s)) continue;
        const Vector normal = (quadric.local_from_world.row(2).transpose() * side).normalized();
        hit = {t_base + s, normal, normal.dot(direction) > 0, end + 1};
    }
    return hit;
}
template<class Real>
std::optional<QuadricHitOf<Real>> first_hit(const SeenQuadric<Real>& quadric,
                                            const Eigen::Vector3<Real>& direction, Real t_near) {
    return first_hit(quadric, direction, closest_approach(quadric.centre, direction), t_near);
}

} // namespace isocast
