// Molecular surfaces against closed forms, brute force, and each other.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/molecular_surface.h"

#include "ball_union_oracle.h"
#include "quadrics/elements.h"
#include "quadrics/molecule.h"
#include "quadrics/probe_cuts.h"
#include "random_primitives.h"
#include "volume/errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <map>

namespace isocast {
namespace {

using ::testing::HasSubstr;

constexpr double probe = 1.4;
/// Values below 2 are stored as floats: half a unit in their last place, 2^-24, and as much for the
/// oracles' and our own rounding at the worst conditioned points.
constexpr double float_rounding = 0x1p-23;

Sphere ball(double x, double y, double z, double radius) {
    return {.centre_world = {x, y, z}, .radius_world = radius};
}

double growth_of(const MolecularSurfaceOptions& options) {
    return options.kind == MolecularSurface::VanDerWaals ? 0 : options.probe_radius_world;
}

double half_width_of(const MolecularSurfaceOptions& options) {
    return options.half_width_voxels * options.voxel_size_world;
}

/// Calls f(position, value, whether it is active) for each stored sample.
template<class Function>
void for_each_sample(const SparseField& field, Function f) {
    for (const FieldBlock& block : field.blocks())
        for (int i = 0; i < samples_per_block; ++i) {
            const Index3 at = block_size * block.coordinate + Index3(i % 8, i / 8 % 8, i / 64);
            f(field.space().to_world(at.cast<double>()), double(block.values[std::size_t(i)]),
              bool(block.active[std::size_t(i)]));
        }
}

/// All samples of the box around the atoms that holds the band, stored or not.
std::vector<std::pair<Vec3d, double>> all_samples(const SparseField& field,
                                                  std::span<const Sphere> atoms,
                                                  const MolecularSurfaceOptions& options) {
    Eigen::AlignedBox3d box;
    const double margin = growth_of(options) + half_width_of(options) + options.voxel_size_world;
    for (const Sphere& s : atoms) {
        box.extend(s.centre_world + Vec3d::Constant(s.radius_world + margin));
        box.extend(s.centre_world - Vec3d::Constant(s.radius_world + margin));
    }
    const IndexBox range{field.space().to_index(box.min()).array().floor().cast<int>(),
                         field.space().to_index(box.max()).array().ceil().cast<int>()};
    std::vector<float> values(std::size_t(range.sample_count()));
    field.copy_box(range, 0, values);
    std::vector<std::pair<Vec3d, double>> samples;
    std::size_t i = 0;
    for (int z = range.lo.z(); z < range.hi.z(); ++z)
        for (int y = range.lo.y(); y < range.hi.y(); ++y)
            for (int x = range.lo.x(); x < range.hi.x(); ++x)
                samples.emplace_back(field.space().to_world(Vec3d(x, y, z)), values[i++]);
    return samples;
}

/// Expects every sample around the atoms to be `distance`, cut to ± the half width.
void expect_is(const std::vector<Sphere>& atoms, const MolecularSurfaceOptions& options,
               const std::function<double(const Vec3d&)>& distance,
               double tolerance = float_rounding) {
    const double half_width = half_width_of(options);
    double worst = 0;
    Vec3d where = Vec3d::Zero();
    int in_band = 0;
    for (const auto& [p, value] : all_samples(molecular_surface(atoms, options), atoms, options)) {
        const double expected = std::clamp(distance(p), -half_width, half_width);
        in_band += std::abs(expected) < half_width;
        if (const double error = std::abs(value - expected); !(error <= worst)) {
            worst = error;
            where = p;
        }
    }
    EXPECT_GT(in_band, 100);
    EXPECT_LE(worst, tolerance) << "at " << where.transpose() << ", where " << distance(where)
                                << " is expected";
}

/// Expects every sample to be what brute force says; beyond cusps its bounds, at some of them.
void expect_brute_force(const std::vector<Sphere>& atoms, const MolecularSurfaceOptions& options,
                        int* cusps = nullptr, double cusp_tolerance = 2e-3) {
    const NaiveUnion grown(atoms, growth_of(options));
    const double half_width = half_width_of(options);
    const double p = options.kind == MolecularSurface::Excluded ? options.probe_radius_world : 0;
    Random random(7);
    for (const auto& [x, value] : all_samples(molecular_surface(atoms, options), atoms, options)) {
        const double height = grown.height(x);
        double expected = p + height;
        if (height < 0) {
            const auto nearest = grown.nearest_outside(x, p + half_width + 1e-3);
            expected = nearest ? p - (*nearest - x).norm() : -half_width;
            if (nearest && expected > 0 && p > 0) {
                const Vec3d y = *nearest + p * (x - *nearest).normalized();
                if (-grown.distance(y, 2 * p) < p - 1e-7) { // in another probe: a cusp
                    ASSERT_GE(value, expected - float_rounding) << x.transpose();
                    if (cusps == nullptr || random.uniform(0, 1) > 0.1) continue;
                    ++*cusps;
                    const Bounds bounds =
                        distance_to_excluded_solid(grown, p, x, half_width, cusp_tolerance);
                    ASSERT_GE(value, bounds.lower - float_rounding) << x.transpose();
                    ASSERT_LE(value, bounds.upper + float_rounding) << x.transpose();
                    ASSERT_LE(bounds.upper - bounds.lower, 30 * cusp_tolerance) << x.transpose();
                    continue;
                }
            }
        }
        expected = std::clamp(expected, -half_width, half_width);
        ASSERT_NEAR(value, expected, float_rounding) << x.transpose();
    }
}

// ------------------------------------------------------------------------------- closed forms

TEST(MolecularSurface, OneAtomIsASphere) {
    const std::vector<Sphere> atoms = {ball(0.3, -0.2, 0.1, 1.7)};
    const auto sphere = [&](double radius) {
        return [&, radius](const Vec3d& p) { return (p - atoms[0].centre_world).norm() - radius; };
    };
    expect_is(atoms, {.kind = MolecularSurface::VanDerWaals, .voxel_size_world = 0.2}, sphere(1.7));
    expect_is(atoms, {.kind = MolecularSurface::Accessible, .voxel_size_world = 0.2}, sphere(3.1));
    expect_is(atoms, {.kind = MolecularSurface::Excluded, .voxel_size_world = 0.2}, sphere(1.7));
}

TEST(MolecularSurface, RandomMoleculesAreBruteForces) {
    Random random(1);
    int cusps = 0;
    for (int n = 0; n < 12; ++n) {
        std::vector<Sphere> atoms;
        for (int i = 0; i < 2 + n % 6; ++i)
            atoms.push_back(
                {.centre_world = random.in_cube(2.5), .radius_world = random.uniform(1, 2)});
        for (const auto kind : {MolecularSurface::VanDerWaals, MolecularSurface::Accessible,
                                MolecularSurface::Excluded})
            expect_brute_force(atoms, {.kind = kind, .voxel_size_world = 0.4}, &cusps);
    }
    EXPECT_GT(cusps, 50);
    std::printf("%d cusps\n", cusps);
}

class ArchiveSurface : public ::testing::TestWithParam<const char*> {};

TEST_P(ArchiveSurface, TakesSeconds) {
    const auto path = std::filesystem::path(ISOCAST_SHARED_DATA) / GetParam();
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    std::vector<Sphere> atoms;
    for (const Atom& atom : read_molecule(path).atoms)
        atoms.push_back({.centre_world = atom.position,
                         .radius_world = element_of(atom.element).van_der_waals_angstrom});
    for (const auto kind : {MolecularSurface::VanDerWaals, MolecularSurface::Accessible,
                            MolecularSurface::Excluded}) {
        const auto start = std::chrono::steady_clock::now();
        const SparseField field = molecular_surface(atoms, {.kind = kind});
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        std::printf("%s kind %d: %zu atoms, %zu blocks, %.0f active, %.3f s\n", GetParam(),
                    int(kind), atoms.size(), field.blocks().size(),
                    double(field.active_voxel_count()), seconds);
    }
}
INSTANTIATE_TEST_SUITE_P(Files, ArchiveSurface,
                         ::testing::Values("1l2y.pdb", "1tii.pdb", "1xnr.cif"));

} // namespace
} // namespace isocast
