// SPDX-License-Identifier: MPL-2.0
#include "quadrics/superquadric.h"

namespace isocast {

namespace {

NormExponents<double> exponents_of(const Superquadric& superquadric) {
    return {2 / superquadric.alpha, 2 / superquadric.beta};
}

} // namespace

std::optional<Superquadric> superquadric_of(const Vec3d& centre_world, const Mat3d& tensor,
                                            const PointLook& look) {
    const TensorAxes axes = axes_of_tensor(tensor);
    const Vec3d lengths = (axes.lengths * look.tensor_scale)
                              .cwiseMax(look.least_axis * look.tensor_scale * axes.lengths[0]);
    if (!(lengths[2] >= least_glyph_size)) return std::nullopt;
    const Vec3d& l = axes.lengths;
    const Vec3d shares = l / l.sum();
    const double c_l = shares[0] - shares[1];
    const double c_p = 2 * (shares[1] - shares[2]);
    const bool is_linear = c_l >= c_p;
    const auto exponent = [&](double c) {
        return std::max(std::pow(std::max(1 - c, 0.0), look.sharpness),
                        least_superquadric_exponent);
    };
    Superquadric superquadric{.centre_world = centre_world,
                              .alpha = exponent(is_linear ? c_p : c_l),
                              .beta = exponent(is_linear ? c_l : c_p)};
    for (int k = 0; k < 3; ++k) {
        const int of = is_linear ? (k + 1) % 3 : k; // the axis is the first or the third
        superquadric.axes_world.col(k) = axes.directions.col(of) * lengths[of];
    }
    return superquadric;
}

template<class Real>
SeenSuperquadric<Real> seen_from(const Superquadric& superquadric, const Vec3d& origin_world) {
    const NormExponents<double> exponents = exponents_of(superquadric);
    return {(superquadric.centre_world - origin_world).cast<Real>(),
            superquadric.axes_world.inverse().cast<Real>(),
            {static_cast<Real>(exponents.p), static_cast<Real>(exponents.r)}};
}
template SeenSuperquadric<float> seen_from(const Superquadric&, const Vec3d&);
template SeenSuperquadric<double> seen_from(const Superquadric&, const Vec3d&);

QuadricDerivatives derivatives(const Superquadric& superquadric, const Vec3d& p_world) {
    const Mat3d m = superquadric.axes_world.inverse();
    const Vec3d q = m * (p_world - superquadric.centre_world);
    const NormExponents<double> exponents = exponents_of(superquadric);
    return {m.transpose() * superquadric_norm(q, exponents).gradient,
            m.transpose() * superquadric_norm_hessian(q, exponents) * m};
}

double support(const Superquadric& superquadric, const Vec3d& n_world) {
    return superquadric_norm(Vec3d(superquadric.axes_world.transpose() * n_world),
                             dual(exponents_of(superquadric)))
        .value;
}

Vec3d farthest_point(const Superquadric& superquadric, const Vec3d& n_world) {
    // The gradient of the dual norm is the point of the unit ball that reaches it.
    const Vec3d n = superquadric.axes_world.transpose() * n_world;
    return superquadric.centre_world +
           superquadric.axes_world *
               superquadric_norm(n, dual(exponents_of(superquadric))).gradient;
}

ScreenBounds screen_bounds(const Superquadric& superquadric, const PictureSpace& space) {
    return superquadric_bounds<double>(space.view_from_world *
                                           (superquadric.centre_world - space.eye_world),
                                       space.view_from_world * superquadric.axes_world,
                                       exponents_of(superquadric), space.is_perspective);
}

} // namespace isocast
