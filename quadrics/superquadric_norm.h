// The norm whose unit ball is a superquadric, in float as in double: the same lines as shaders'.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace isocast {

/// N(x, y, z) = (M^r + |z|^r)^(1/r) with M = (|x|^p + |y|^p)^(1/p): a norm for p, r >= 1, so that
/// it is convex along any line. The superquadric of Kindlmann 2004,
/// (|x|^(2/alpha) + |y|^(2/alpha))^(alpha/beta) + |z|^(2/beta) = 1, is N = 1.
template<class Real>
struct NormExponents {
    Real p = 2; // 2 / alpha
    Real r = 2; // 2 / beta
};

/// Those of the dual norm, whose value at a direction is the greatest product of the direction with
/// a point of the unit ball: by Hoelder's inequality, u . q <= M*(u) M(q) + |u_z| |q_z| <= N*(u)
/// N(q) with M* and N* of 1/p + 1/p* = 1 and 1/r + 1/r* = 1, and where N* is differentiable its
/// gradient is the point that reaches it.
template<class Real>
NormExponents<Real> dual(const NormExponents<Real>& e) {
    return {e.p / (e.p - 1), e.r / (e.r - 1)};
}

/// (|a|^e + |b|^e)^(1/e) and its derivatives by |a| and |b|, which are 0 to 1.
///
/// Powers are of the lesser over the greater, so that none overflows, and one that underflows is
/// added to 1; u^e / u needs no further power. At 0 the derivatives are (1, 0), one of many.
template<class Real>
struct PairNorm {
    Real value, by_a, by_b;
};
template<class Real>
PairNorm<Real> pair_norm(Real a, Real b, Real e) {
    const Real greater = std::max(a, b), lesser = std::min(a, b);
    const Real u = greater > 0 ? lesser / greater : Real(0);
    const Real u_e = u > 0 ? std::pow(u, e) : Real(0);
    const Real sum = 1 + u_e;
    const Real root = std::pow(sum, 1 / e);
    const Real by_greater = root / sum; // (greater / value)^(e - 1)
    const Real by_lesser = u > 0 ? by_greater * (u_e / u) : Real(0);
    return {greater * root, a >= b ? by_greater : by_lesser, a >= b ? by_lesser : by_greater};
}

template<class Real>
struct NormValue {
    Real value = 0;
    Eigen::Vector3<Real> gradient; // its dual norm is 1, so that it is never 0
};

/// N and its gradient at q.
///
/// accuracy  the value within 4 roundings, whatever the exponents: a power's error counts
///           1 / exponent times in the root of the sum; the gradient within 8 roundings of 1
template<class Real>
NormValue<Real> superquadric_norm(const Eigen::Vector3<Real>& q, const NormExponents<Real>& e) {
    const PairNorm<Real> m = pair_norm(std::abs(q.x()), std::abs(q.y()), e.p);
    const PairNorm<Real> n = pair_norm(m.value, std::abs(q.z()), e.r);
    const auto with_sign = [](Real size, Real of) { return of < 0 ? -size : size; };
    return {n.value,
            {with_sign(n.by_a * m.by_a, q.x()), with_sign(n.by_a * m.by_b, q.y()),
             with_sign(n.by_b, q.z())}};
}

/// The Hessian of N at q with N(q) = 1.
///
/// It exists on all of the surface where p, r > 2, or p = r = 2, or p = 2 < r: wherever
/// beta <= alpha <= 1, as of Kindlmann's tensors. Flat faces have 0 there, their edges, which are
/// rounded, grow with the exponents. With r = 2 < p the poles x = y = 0 have a bend that depends on
/// the direction; the value is then that towards x.
///
/// source  with ratios X = |x| / M, Y = |y| / M, U = M / N, V = |z| / N:
///         N_MM = (r - 1) U^(r-2) V^r / N, N_Mz = -(r - 1) U^(r-1) V^(r-1) / N, and likewise for M
///         by x and y, with U^(r-1) / M as U^(r-2) / N: nothing is divided by what can be 0
template<class Real>
Eigen::Matrix3<Real> superquadric_norm_hessian(const Eigen::Vector3<Real>& q,
                                               const NormExponents<Real>& e) {
    const auto power = [](Real x, Real n) { return n == 0 ? Real(1) : std::pow(x, n); };
    const Real m = pair_norm(std::abs(q.x()), std::abs(q.y()), e.p).value;
    const Real n = pair_norm(m, std::abs(q.z()), e.r).value;
    // Signs go with the ratios.
    const Real x = m > 0 ? std::abs(q.x()) / m : Real(1);
    const Real y = m > 0 ? std::abs(q.y()) / m : Real(0);
    const Real u = m / n, v = std::abs(q.z()) / n;
    const Real x2 = power(x, e.p - 2), y2 = power(y, e.p - 2);
    const Real u2 = power(u, e.r - 2), v2 = power(v, e.r - 2);

    // Of M by x and y: the gradient, and the Hessian times M.
    const Real m_x = x2 * x, m_y = y2 * y;
    const Real m_xx = (e.p - 1) * x2 * y2 * y * y;
    const Real m_yy = (e.p - 1) * y2 * x2 * x * x;
    const Real m_xy = -(e.p - 1) * m_x * m_y;
    // Of N by M and z, times N; u2 is N_M / M, times N.
    const Real n_mm = (e.r - 1) * u2 * v2 * v * v;
    const Real n_zz = (e.r - 1) * v2 * u2 * u * u;
    const Real n_mz = -(e.r - 1) * u2 * u * v2 * v;

    const Eigen::Vector3<Real> sign(q.x() < 0 ? -1 : 1, q.y() < 0 ? -1 : 1, q.z() < 0 ? -1 : 1);
    Eigen::Matrix3<Real> h;
    h(0, 0) = n_mm * m_x * m_x + u2 * m_xx;
    h(1, 1) = n_mm * m_y * m_y + u2 * m_yy;
    h(2, 2) = n_zz;
    h(0, 1) = h(1, 0) = n_mm * m_x * m_y + u2 * m_xy;
    h(0, 2) = h(2, 0) = n_mz * m_x;
    h(1, 2) = h(2, 1) = n_mz * m_y;
    return (sign.asDiagonal() * h * sign.asDiagonal()) / n;
}

} // namespace isocast
