// Fields that ray casters miss: control samples of a B-spline with parts thinner than a voxel.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../volume/random_fields.h"
#include "filtering/filter.h"
#include "raycaster/camera.h"
#include "volume/analytic_fields.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace isocast::test {

/// Control samples with unit voxels in [0, n)^3, sample i at world i; negative inside.
struct HardField {
    std::string name;
    std::shared_ptr<const DenseField> control;
    /// Thickness of the thinnest part, across it [voxel].
    double thickness_voxels;
};

/// Control samples value(p) in [0, n)^3, computed in double.
template<class Value>
std::shared_ptr<const DenseField> control_of(int n, Value value) {
    const IndexBox extent{Index3::Zero(), Index3::Constant(n)};
    std::vector<float> values;
    values.reserve(static_cast<std::size_t>(extent.sample_count()));
    for_each_sample(extent, [&](const Index3& i) {
        values.push_back(static_cast<float>(value(Vec3d(i.cast<double>()))));
    });
    return std::make_shared<DenseField>(GridSpace::uniform(1), extent, std::move(values));
}

/// s^2 up to `knee`, going on along its tangent: near s = 0 a quadratic, which the B-spline
/// reproduces up to a constant; far away no steeper than 2 knee.
inline double square_with_knee(double s, double knee) {
    return std::abs(s) <= knee ? s * s : knee * (2 * std::abs(s) - knee);
}

// The spline of control samples q is q + (Laplacian of q)/6 where q is a quadratic on all that the
// point reads: 2 sqrt 3 = 3.5 voxels, so knees are at 4. All is divided by 8: slope 1 far away.

/// A sheet through the middle, its normal at random, whose spline is (s^2 - w^2)/8 near it for the
/// distance s from its middle: negative for |s| < w = thickness/2. Its values there reach -w^2/8
/// only, 1.25e-5 for the default thickness, where control samples of 2 round to 1e-7.
struct ThinSheet {
    HardField field;
    Vec3d p_on_sheet;
    Vec3d normal;
};

inline ThinSheet thin_sheet(int n, unsigned seed, double thickness_voxels = 0.02) {
    Random random(seed);
    const Vec3d normal = random_point(random, -1, 1).normalized();
    const Vec3d middle = Vec3d::Constant(0.5 * n) + random_point(random, -1, 1);
    const double w = thickness_voxels / 2;
    auto control = control_of(n, [&](const Vec3d& p) {
        // The Laplacian of s^2 is 2.
        return (square_with_knee(normal.dot(p - middle), 4) - w * w - 2.0 / 6) / 8;
    });
    return {{"thin sheet", std::move(control), thickness_voxels}, middle, normal};
}

/// A spherical shell of radius about n/3: the spline through the samples of (s^2 - w^2)/8.
struct ThinShell {
    HardField field;
    Vec3d centre;
    double radius;
};

inline ThinShell thin_shell(int n, unsigned seed, double thickness_voxels = 0.1) {
    Random random(seed);
    const Vec3d centre = Vec3d::Constant(0.5 * (n - 1)) + random_point(random, -1, 1);
    const double radius = n / 3.0 + random_real(random, -1, 1);
    const double w = thickness_voxels / 2;
    // The knee farther away: what the exact prefilter makes of it fades by 0.27 a voxel.
    const auto samples = control_of(n, [&](const Vec3d& p) {
        return (square_with_knee((p - centre).norm() - radius, 8) - w * w) / 8;
    });
    const auto control = control_samples(samples, Filter::Exact);
    return {{"thin shell", std::dynamic_pointer_cast<const DenseField>(control), thickness_voxels},
            centre,
            radius};
}

/// A torus with a thin tube, off the lattice and tilted: control samples are its distances.
inline HardField tilted_torus(int n, unsigned seed) {
    Random random(seed);
    const Vec3d centre = Vec3d::Constant(0.5 * (n - 1)) + random_point(random, -1, 1);
    const double tube = 2 + random_real(random, 0, 1);
    const AnalyticField torus =
        torus_field(centre, random_point(random, -1, 1) + Vec3d(0, 0, 2), n / 3.0, tube);
    return {"torus", control_of(n, [&](const Vec3d& p) { return torus.jet(p).value; }), 2 * tube};
}

/// Needles that stand on the plane z = 0, tilted at random, and end in points: paraboloids
/// rho^2 = radius^2 (1 - h) for the distance rho from the axis and the height h, 1 at the tip.
/// Where two needles come within 7 voxels of each other the spline smooths over the minimum of
/// both, and they are up to twice as wide.
inline HardField needles(int n, unsigned seed, int count = 24, double radius_voxels = 0.3) {
    Random random(seed);
    struct Needle {
        Vec3d base;
        Vec3d axis;
        double length;
    };
    std::vector<Needle> forest(static_cast<std::size_t>(count));
    for (Needle& needle : forest) {
        needle.base = random_point(random, 0.1 * n, 0.9 * n);
        needle.base.z() = 0;
        needle.axis = (random_point(random, -0.3, 0.3) + Vec3d::UnitZ()).normalized();
        needle.length = n * random_real(random, 0.4, 0.9);
    }
    const auto control = control_of(n, [&](const Vec3d& p) {
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

/// Waves of random directions, 10 voxels long and more: surfaces everywhere, of all curvatures,
/// with necks and islands as thin as chance makes them.
inline HardField smooth_noise(int n, unsigned seed, int waves = 24) {
    Random random(seed);
    struct Wave {
        Vec3d k;
        double phase;
    };
    std::vector<Wave> sum(static_cast<std::size_t>(waves));
    for (Wave& wave : sum) {
        wave.k = random_point(random, -1, 1).normalized() * random_real(random, 0.2, 0.6);
        wave.phase = random_real(random, 0, 2 * std::numbers::pi);
    }
    const auto control = control_of(n, [&](const Vec3d& p) {
        double value = 0;
        for (const Wave& wave : sum) value += std::cos(wave.k.dot(p) + wave.phase);
        return value;
    });
    return {"smooth noise", control, 0};
}

/// One of each.
inline std::vector<HardField> hard_fields(int n, unsigned seed) {
    return {thin_sheet(n, seed).field, thin_shell(n, seed).field, tilted_torus(n, seed),
            needles(n, seed), smooth_noise(n, seed)};
}

/// A ray from a random point outside the cube [0, n)^3 towards a random point within it.
inline Ray random_ray(Random& random, int n) {
    const Vec3d to = random_point(random, 0, n - 1);
    const Vec3d away = random_point(random, -1, 1).normalized();
    const Vec3d from = Vec3d::Constant(0.5 * (n - 1)) + 2.0 * n * away;
    return {from, (to - from).normalized()};
}

} // namespace isocast::test
