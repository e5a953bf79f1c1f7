// SPDX-License-Identifier: MPL-2.0
#include "stability/hard_fields.h"

#include "filtering/filter.h"
#include "volume/analytic_fields.h"

namespace isocast::stability {

namespace {

/// s^2 up to `knee`, going on along its tangent: near s = 0 a quadratic, which the B-spline
/// reproduces up to a constant, a sixth of its Laplacian; far away no steeper than 2 knee.
double square_with_knee(double s, double knee) {
    return std::abs(s) <= knee ? s * s : knee * (2 * std::abs(s) - knee);
}

} // namespace

// The spline reads 2 sqrt 3 = 3.5 voxels around a point, so knees are at 4. All is divided by 8:
// slope 1 far away.

ThinSheet thin_sheet(int n, unsigned seed, double thickness_voxels) {
    Random random(seed);
    const Vec3d normal = random.unit();
    const Vec3d middle = Vec3d::Constant(0.5 * n) + random.in_cube();
    const double w = thickness_voxels / 2;
    return {unit_field(n,
                       [&](const Vec3d& p) {
                           return (square_with_knee(normal.dot(p - middle), 4) - w * w - 2.0 / 6) /
                                  8;
                       }),
            middle, normal};
}

std::shared_ptr<const FieldSource> thin_shell(int n, double thickness_voxels) {
    const Vec3d centre = Vec3d::Constant(0.5 * (n - 1)) + Vec3d(0.3, -0.2, 0.1);
    const double w = thickness_voxels / 2;
    // The knee farther away: what the exact prefilter makes of it fades by 0.27 a voxel.
    return control_samples(
        unit_field(n,
                   [&](const Vec3d& p) {
                       return (square_with_knee((p - centre).norm() - n / 3.0, 8) - w * w) / 8;
                   }),
        Filter::Exact);
}

std::shared_ptr<const FieldSource> tilted_torus(int n, unsigned seed) {
    Random random(seed);
    const AnalyticField torus =
        torus_field(Vec3d::Constant(0.5 * (n - 1)) + random.in_cube(),
                    random.in_cube() + Vec3d(0, 0, 2), n / 3.0, random.uniform(2, 3));
    return unit_field(n, [&](const Vec3d& p) { return torus.jet(p).value; });
}

std::shared_ptr<const FieldSource> needles(int n, unsigned seed) {
    Random random(seed);
    struct Needle {
        Vec3d base, axis;
        double length;
    };
    std::vector<Needle> forest(24);
    for (Needle& needle : forest) {
        needle.base = Vec3d(random.uniform(0.1 * n, 0.9 * n), random.uniform(0.1 * n, 0.9 * n), 0);
        needle.axis = (random.in_cube(0.3) + Vec3d::UnitZ()).normalized();
        needle.length = n * random.uniform(0.4, 0.9);
    }
    return unit_field(n, [&](const Vec3d& p) {
        double least = 1e30;
        for (const Needle& needle : forest) {
            const Vec3d offset = p - needle.base;
            const double along = offset.dot(needle.axis);
            const double rho = (offset - along * needle.axis).norm();
            least = std::min(least, square_with_knee(rho, 4) - 0.09 * (1 - along / needle.length));
        }
        // The Laplacian of rho^2 is 4.
        return (least - 4.0 / 6) / 8;
    });
}

std::shared_ptr<const FieldSource> smooth_noise(int n, unsigned seed) {
    Random random(seed);
    std::vector<std::pair<Vec3d, double>> waves(24);
    for (auto& [k, phase] : waves) {
        k = random.unit() * random.uniform(0.2, 0.6);
        phase = random.uniform(0, 6.3);
    }
    return unit_field(n, [&](const Vec3d& p) {
        double value = 0;
        for (const auto& [k, phase] : waves) value += std::cos(k.dot(p) + phase);
        return value;
    });
}

} // namespace isocast::stability
