// SPDX-License-Identifier: MPL-2.0
#include "stability/hard_fields.h"

#include "filtering/filter.h"
#include "volume/analytic_fields.h"

#include <cmath>
#include <numbers>
#include <random>

namespace isocast::stability {

namespace {

double real(std::mt19937& random, double lo, double hi) {
    return std::uniform_real_distribution(lo, hi)(random);
}

Vec3d point(std::mt19937& random, double lo, double hi) {
    const double x = real(random, lo, hi);
    const double y = real(random, lo, hi);
    return {x, y, real(random, lo, hi)};
}

/// s^2 up to `knee`, going on along its tangent: near s = 0 a quadratic, which the B-spline
/// reproduces up to a constant; far away no steeper than 2 knee.
double square_with_knee(double s, double knee) {
    return std::abs(s) <= knee ? s * s : knee * (2 * std::abs(s) - knee);
}

} // namespace

// The spline of control samples q is q + (Laplacian of q)/6 where q is a quadratic on all that the
// point reads: 2 sqrt 3 = 3.5 voxels, so knees are at 4. All is divided by 8: slope 1 far away.

ThinSheet thin_sheet(int n, unsigned seed, double thickness_voxels) {
    std::mt19937 random(seed);
    const Vec3d normal = point(random, -1, 1).normalized();
    const Vec3d middle = Vec3d::Constant(0.5 * n) + point(random, -1, 1);
    const double w = thickness_voxels / 2;
    auto control = unit_field(n, [&](const Vec3d& p) {
        // The Laplacian of s^2 is 2.
        return (square_with_knee(normal.dot(p - middle), 4) - w * w - 2.0 / 6) / 8;
    });
    return {{"thin sheet", std::move(control), thickness_voxels}, middle, normal};
}

ThinShell thin_shell(int n, unsigned seed, double thickness_voxels) {
    std::mt19937 random(seed);
    const Vec3d centre = Vec3d::Constant(0.5 * (n - 1)) + point(random, -1, 1);
    const double radius = n / 3.0 + real(random, -1, 1);
    const double w = thickness_voxels / 2;
    // The knee farther away: what the exact prefilter makes of it fades by 0.27 a voxel.
    const auto samples = unit_field(n, [&](const Vec3d& p) {
        return (square_with_knee((p - centre).norm() - radius, 8) - w * w) / 8;
    });
    const auto control = control_samples(samples, Filter::Exact);
    return {{"thin shell", std::dynamic_pointer_cast<const DenseField>(control), thickness_voxels},
            centre,
            radius};
}

HardField tilted_torus(int n, unsigned seed) {
    std::mt19937 random(seed);
    const Vec3d centre = Vec3d::Constant(0.5 * (n - 1)) + point(random, -1, 1);
    const double tube = 2 + real(random, 0, 1);
    const AnalyticField torus =
        torus_field(centre, point(random, -1, 1) + Vec3d(0, 0, 2), n / 3.0, tube);
    return {"torus", unit_field(n, [&](const Vec3d& p) { return torus.jet(p).value; }), 2 * tube};
}

HardField needles(int n, unsigned seed, int count, double radius_voxels) {
    std::mt19937 random(seed);
    struct Needle {
        Vec3d base;
        Vec3d axis;
        double length;
    };
    std::vector<Needle> forest(static_cast<std::size_t>(count));
    for (Needle& needle : forest) {
        needle.base = point(random, 0.1 * n, 0.9 * n);
        needle.base.z() = 0;
        needle.axis = (point(random, -0.3, 0.3) + Vec3d::UnitZ()).normalized();
        needle.length = n * real(random, 0.4, 0.9);
    }
    const auto control = unit_field(n, [&](const Vec3d& p) {
        double least = 1e30;
        for (const Needle& needle : forest) {
            const Vec3d offset = p - needle.base;
            const double along = offset.dot(needle.axis);
            const double rho = (offset - along * needle.axis).norm();
            const double h = along / needle.length;
            least =
                std::min(least, square_with_knee(rho, 4) - radius_voxels * radius_voxels * (1 - h));
        }
        // The Laplacian of rho^2 is 4.
        return (least - 4.0 / 6) / 8;
    });
    return {"needles", control, 2 * radius_voxels};
}

HardField smooth_noise(int n, unsigned seed, int waves) {
    std::mt19937 random(seed);
    struct Wave {
        Vec3d k;
        double phase;
    };
    std::vector<Wave> sum(static_cast<std::size_t>(waves));
    for (Wave& wave : sum) {
        wave.k = point(random, -1, 1).normalized() * real(random, 0.2, 0.6);
        wave.phase = real(random, 0, 2 * std::numbers::pi);
    }
    const auto control = unit_field(n, [&](const Vec3d& p) {
        double value = 0;
        for (const Wave& wave : sum) value += std::cos(wave.k.dot(p) + wave.phase);
        return value;
    });
    return {"smooth noise", control, 0};
}

std::vector<HardField> hard_fields(int n, unsigned seed) {
    return {thin_sheet(n, seed).field, thin_shell(n, seed).field, tilted_torus(n, seed),
            needles(n, seed), smooth_noise(n, seed)};
}

} // namespace isocast::stability
