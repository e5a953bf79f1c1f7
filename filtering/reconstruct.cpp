// From samples to the smooth function, its gradient and Hessian, in double.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/reconstruct.h"

namespace isocast {

namespace {

/// The 4^3 control samples that a point reads, and where it lies in its cell.
struct Support {
    std::array<float, 64> samples; // x fastest
    Vec3d fraction;                // in [0, 1)^3
};

Support support_of(const FieldSource& field, const Vec3d& p_index) {
    const Vec3d cell = p_index.array().floor();
    const Index3 lo = (cell.cast<int>().array() - 1).matrix();
    Support support{{}, p_index - cell};
    field.copy_box({lo, (lo.array() + 4).matrix()}, 0, support.samples);
    return support;
}

/// The sum of the control samples with weights x, y and z along the axes (thesis eq. 5.1 thrice).
double convolve(const std::array<float, 64>& samples, const std::array<double, 4>& x,
                const std::array<double, 4>& y, const std::array<double, 4>& z) {
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t j = 0; j < 4; ++j) {
            const float* row = &samples[4 * (j + 4 * k)];
            const double along_x = x[0] * row[0] + x[1] * row[1] + x[2] * row[2] + x[3] * row[3];
            sum += z[k] * y[j] * along_x;
        }
    }
    return sum;
}

} // namespace

double kernel_value(const FieldSource& field, const Vec3d& p_index, Kernel kernel) {
    const auto [samples, a] = support_of(field, p_index);
    return convolve(samples, kernel_weights(kernel, a.x()), kernel_weights(kernel, a.y()),
                    kernel_weights(kernel, a.z()));
}

Jet kernel_jet(const FieldSource& field, const Vec3d& p_index, Kernel kernel) {
    const auto [samples, a] = support_of(field, p_index);
    // weights[axis][order]: each derivative takes the derived weights along its axes.
    std::array<std::array<std::array<double, 4>, 3>, 3> weights;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double fraction = a[static_cast<int>(axis)];
        weights[axis] = {kernel_weights(kernel, fraction), kernel_weights_d1(kernel, fraction),
                         kernel_weights_d2(kernel, fraction)};
    }
    const auto derivative = [&, &samples = samples](const Index3& order) {
        const auto along = [&](std::size_t axis) {
            return weights[axis][static_cast<std::size_t>(order[static_cast<int>(axis)])];
        };
        return convolve(samples, along(0), along(1), along(2));
    };
    Jet jet;
    jet.value = derivative(Index3::Zero());
    for (int i = 0; i < 3; ++i) {
        jet.gradient[i] = derivative(Index3::Unit(i));
        for (int j = 0; j <= i; ++j) {
            jet.hessian(i, j) = jet.hessian(j, i) = derivative(Index3::Unit(i) + Index3::Unit(j));
        }
    }
    return jet;
}

double tricubic_value(const FieldSource& field, const Vec3d& p_index) {
    return kernel_value(field, p_index, Kernel::BSpline);
}

Jet tricubic_jet(const FieldSource& field, const Vec3d& p_index) {
    return kernel_jet(field, p_index, Kernel::BSpline);
}

} // namespace isocast
