// From samples to functions: weights, filters, resolutions side by side, numbers of any size.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/coarsened_field.h"
#include "filtering/filter.h"
#include "filtering/morph.h"
#include "filtering/reconstruct.h"
#include "filtering/smoothed_field.h"
#include "stability/cases.h"
#include "stability/fields.h"
#include "volume/blended_field.h"

#include <numeric>

namespace isocast::stability {

namespace {

constexpr std::array kernels{Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom};

/// Sums over the samples -1, 0, 1, 2 of the weights times their place to a power.
double moment(const std::array<double, 4>& weights, int power) {
    double sum = 0;
    for (int i = 0; i < 4; ++i)
        sum += weights[static_cast<std::size_t>(i)] * std::pow(i - 1, power);
    return sum;
}

Worst weights_sum_to_one() {
    Worst worst;
    for (const Kernel kernel : kernels)
        for (int i = 0; i <= 1000; ++i)
            worst.see(std::abs(moment(kernel_weights(kernel, i / 1000.0), 0) - 1));
    return worst;
}

/// Eq. 5.2 and 5.9 as printed fail here: the moments are those of a, 1 and 0.
Worst weights_have_their_moments() {
    Worst worst;
    for (const Kernel kernel : kernels)
        for (int i = 0; i <= 1000; ++i) {
            const double a = i / 1000.0;
            worst.see(std::abs(moment(kernel_weights(kernel, a), 1) - a));
            worst.see(std::abs(moment(kernel_weights_d1(kernel, a), 0)));
            worst.see(std::abs(moment(kernel_weights_d1(kernel, a), 1) - 1));
            worst.see(std::abs(moment(kernel_weights_d2(kernel, a), 0)));
            worst.see(std::abs(moment(kernel_weights_d2(kernel, a), 1)));
        }
    for (int i = 0; i <= 1000; ++i) {
        const double a = i / 1000.0;
        worst.see(std::abs(moment(bspline_weights(a), 2) - (a * a + 1.0 / 3)));
        worst.see(std::abs(moment(bspline_weights_d1(a), 2) - 2 * a));
        worst.see(std::abs(moment(bspline_weights_d2(a), 2) - 2));
    }
    return worst;
}

/// At the end of a cell and the start of the next, value and two derivatives of the B-spline.
Worst cells_join() {
    Worst worst;
    const auto join = [&](const std::array<double, 4>& end, const std::array<double, 4>& start) {
        worst.see(std::abs(end[0]));
        worst.see(std::abs(start[3]));
        for (std::size_t i = 0; i < 3; ++i) worst.see(std::abs(end[i + 1] - start[i]));
    };
    join(bspline_weights(1), bspline_weights(0));
    join(bspline_weights_d1(1), bspline_weights_d1(0));
    join(bspline_weights_d2(1), bspline_weights_d2(0));
    return worst;
}

/// x^3 - 2 y^2 z + x y z and its like are in the fourth-order filters' reach.
Worst cubics_are_reproduced(Filter filter) {
    const auto cubic = [](const Vec3d& q) -> double {
        const Vec3d p = (q - Vec3d::Constant(8)) / 8;
        return p.x() * p.x() * p.x() - 2 * p.y() * p.y() * p.z() + p.x() * p.y() * p.z() + p.z();
    };
    const auto control = control_samples(unit_field(17, cubic), filter);
    Random random(1);
    Worst worst;
    for (int i = 0; i < 500; ++i) {
        const Vec3d p = Vec3d::Constant(8) + random.in_cube(4);
        worst.see(std::abs(kernel_value(*control, p, kernel_of(filter)) - cubic(p)));
    }
    return worst;
}

Worst exact_passes_the_samples() {
    const auto noise = white_noise(20, 2);
    const auto control = control_samples(noise, Filter::Exact);
    Worst worst;
    for_each_sample(noise->extent(), [&](const Index3& i) {
        worst.see(std::abs(tricubic_value(*control, i.cast<double>()) - sample(*noise, i)));
    });
    return worst;
}

/// Value, gradient and Hessian on both sides of faces between blocks of three resolutions: from
/// points 2^-20 of a voxel apart, less what the function's own slopes make of that.
Worst resolutions_meet() {
    const auto noise = white_noise(33, 3);
    BlockLevels levels;
    for_each_sample({Index3::Zero(), Index3::Constant(4)}, [&](const Index3& block) {
        levels.set(block, (block.x() + 2 * block.y() + 3 * block.z()) % 4);
    });
    const CoarsenedField field(noise, levels);
    Random random(4);
    Worst worst;
    constexpr double step = 0x1p-20;
    for (int i = 0; i < 600; ++i) {
        const int axis = i % 3;
        Vec3d p = Vec3d::Constant(16) + random.in_cube(15);
        p[axis] = 8 * (1 + i / 3 % 3);
        const Jet above = tricubic_jet(field, p + step * Vec3d::Unit(axis));
        const Jet below = tricubic_jet(field, p - step * Vec3d::Unit(axis));
        worst.see(std::abs(above.value - below.value - 2 * step * above.gradient[axis]));
        worst.see((above.gradient - below.gradient - 2 * step * above.hessian.col(axis)).norm());
    }
    return worst;
}

/// The jets of a field and of the same times a power of two, which must be the same times it.
Worst scales_exactly(int exponent) {
    const auto noise = white_noise(12, 5);
    const double scale = std::exp2(exponent);
    std::vector<float> values(noise->values().begin(), noise->values().end());
    for (float& value : values) value = static_cast<float>(value * scale);
    const auto scaled = std::make_shared<DenseField>(noise->space(), noise->extent(), values);
    Random random(6);
    Worst worst;
    for (const Filter filter : {Filter::Linear, Filter::BSpline, Filter::Interpolating,
                                Filter::Exact, Filter::CatmullRom}) {
        const auto a = control_samples(noise, filter);
        const auto b = control_samples(scaled, filter);
        for (int i = 0; i < 100; ++i) {
            const Vec3d p = Vec3d::Constant(5.5) + random.in_cube(5);
            const Jet one = kernel_jet(*a, p, kernel_of(filter));
            const Jet other = kernel_jet(*b, p, kernel_of(filter));
            worst.see(std::abs(other.value / scale - one.value));
            worst.see((other.gradient / scale - one.gradient).norm());
            worst.see((other.hessian / scale - one.hessian).norm());
        }
    }
    return worst;
}

/// Near the end of the floats a control sample loses digits, but no more than their spacing.
Worst denormals_keep_their_spacing() {
    Random random(7);
    const auto tiny = unit_field(8, [&](const Vec3d&) { return random.uniform(-1, 1) * 0x1p-140; });
    Worst worst;
    for (int i = 0; i < 200; ++i) {
        const Vec3d p = Vec3d::Constant(3.5) + random.in_cube(2);
        double sum = 0;
        const Index3 cell = p.array().floor().cast<int>();
        for_each_sample({(cell.array() - 1).matrix(), (cell.array() + 3).matrix()},
                        [&](const Index3& at) {
                            double weight = 1;
                            for (int k = 0; k < 3; ++k)
                                weight *= bspline_weights(
                                    p[k] - cell[k])[static_cast<std::size_t>(at[k] - cell[k] + 1)];
                            sum += weight * sample(*tiny, at);
                        });
        worst.see(std::abs(tricubic_value(*tiny, p) - sum) / 0x1p-149);
    }
    return worst;
}

/// The same samples about index 0 and about `shift`.
Worst indices_far_from_zero(int shift) {
    const auto noise = white_noise(10, 8);
    const Index3 by = Index3::Constant(shift);
    const DenseField far(noise->space(), {by, (by.array() + 10).matrix()},
                         {noise->values().begin(), noise->values().end()});
    Random random(9);
    Worst worst;
    for (int i = 0; i < 200; ++i) {
        // Multiples of 2^-20: exact at either place.
        Vec3d p = Vec3d::Constant(4.5) + random.in_cube(4);
        p = (p * 0x1p20).array().round() * 0x1p-20;
        const Jet near_zero = tricubic_jet(*noise, p);
        const Jet there = tricubic_jet(far, p + by.cast<double>());
        worst.must(near_zero.value == there.value && near_zero.gradient == there.gradient &&
                   near_zero.hessian == there.hessian);
    }
    return worst;
}

Worst gaussian_keeps_quadratics() {
    const auto quadratic = [](const Vec3d& p) -> double {
        const Vec3d q = (p - Vec3d::Constant(12)) / 12;
        return q.x() * q.x() - 0.5 * q.y() * q.y() + q.x() * q.z();
    };
    const auto field = unit_field(25, quadratic);
    const SmoothedField smoothed(field, 1.5);
    Worst worst;
    // Half the variance times the Laplacian, 2 - 1 over 144.
    for_each_sample({Index3::Constant(10), Index3::Constant(15)}, [&](const Index3& i) {
        worst.see(
            std::abs(sample(smoothed, i) - quadratic(i.cast<double>()) - 0.5 * 1.5 * 1.5 / 144));
    });
    return worst;
}

Worst blends_end_at_their_operands() {
    const auto a = white_noise(9, 10);
    const auto b = white_noise(9, 11);
    Worst worst;
    for (const auto& [t, end] : {std::pair{0.0, a}, std::pair{1.0, b}})
        for_each_sample(a->extent(), [&](const Index3& i) {
            worst.must(sample(BlendedField(a, b, t), i) == sample(*end, i));
        });
    return worst;
}

Worst bands_that_do_not_meet_say_so() {
    const auto ball = [](double x) {
        AnalyticField sphere = sphere_field({x, 0, 0}, 0.2);
        return std::shared_ptr<const FieldSource>(sampled(sphere, 33, 2.0));
    };
    Worst worst;
    worst.must(morph(ball(-0.6), ball(0.6), 0.5).warning.has_value());
    worst.must(!morph(ball(-0.01), ball(0.01), 0.5).warning.has_value());
    return worst;
}

} // namespace

void append_filtering_cases(std::vector<Case>& cases) {
    const auto add = [&](const char* name, const char* compares, double bound, const char* from,
                         auto run) {
        cases.push_back({std::string("filtering.") + name, compares, bound, from,
                         [run](Devices&) { return run(); }});
    };
    const char* rounding_of_four = "four roundings of weights below 1";
    add("weights-sum-to-one", "sum of each kernel's weights and 1", 4 * 0x1p-53, rounding_of_four,
        weights_sum_to_one);
    add("weights-have-their-moments",
        "moments of weights and derivatives (eqs 5.2, 5.9) and "
        "those of polynomials",
        32 * 0x1p-53, "four roundings of products up to 8", weights_have_their_moments);
    add("cells-join", "weights of value and two derivatives across cells", 4 * 0x1p-53,
        rounding_of_four, cells_join);
    add("interpolating-keeps-cubics", "quasi-interpolant of a cubic and the cubic", 16 * 0x1p-24,
        "samples up to 4 and control samples round to float",
        [] { return cubics_are_reproduced(Filter::Interpolating); });
    add("exact-keeps-cubics", "prefiltered spline of a cubic and the cubic", 3e-4,
        "the border's bend fades by 0.27 a voxel: 0.27^4 of its 2nd difference, 0.05",
        [] { return cubics_are_reproduced(Filter::Exact); });
    add("exact-passes-the-samples", "prefiltered spline of white noise at its samples and these",
        8 * 0x1p-24, "27 coefficients up to 27, rounded to float", exact_passes_the_samples);
    add("two-resolutions-meet",
        "value and gradient on both sides of faces between blocks of 1, 2, "
        "4 and 8 voxels",
        0x1p-36, "third derivatives up to 8 times steps of 2^-20, squared", resolutions_meet);
    for (const auto& [name, exponent] :
         {std::pair{"units-of-1e-9", -30}, std::pair{"units-of-1e9", 30},
          std::pair{"units-of-1e-30", -100}, std::pair{"units-of-1e30", 100}})
        add(name, "jets of noise by each filter and of the same in these units", 0,
            "powers of two scale exactly",
            [exponent = exponent] { return scales_exactly(exponent); });
    add("denormals", "spline of samples near 2^-140 and 64 products in double [2^-149]", 1e-9,
        "both sums are in double, whose exponents reach", denormals_keep_their_spacing);
    for (const int shift : {1 << 20, 1 << 28})
        add(shift == 1 << 20 ? "index-2^20" : "index-2^28",
            "jets of the same samples at index 0 and far from it", 0, "bit for bit",
            [shift] { return indices_far_from_zero(shift); });
    add("gaussian-keeps-quadratics", "a smoothed quadratic and the quadratic with its shift",
        4 * 0x1p-24, "1e-6 of the weights is left out and scaled away; samples round to float",
        gaussian_keeps_quadratics);
    add("blend-ends-at-operands", "(1 - t) a + t b at t = 0 and 1 and a and b", 0, "bit for bit",
        blends_end_at_their_operands);
    add("morph-of-bands-apart-warns", "whether a morph between bands that do not meet says so", 0,
        "it must", bands_that_do_not_meet_say_so);
}

} // namespace isocast::stability
