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

#include <array>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>

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

/// Which samples beyond cusps of the excluded surface are compared, and how many were.
struct CuspCheck {
    double fraction = 0.5;
    int compared = 0;
    int loose = 0; // of these, where the bounds are 0.05 apart: the solid is too thin there
};

/// Expects `fraction` of all samples around the atoms to be what brute force says; those beyond
/// cusps to be no less than the distance to the nearest probe's sphere, and some of them to be
/// between the bounds of branch and bound.
void expect_brute_force(const std::vector<Sphere>& atoms, const MolecularSurfaceOptions& options,
                        CuspCheck* cusps = nullptr, double fraction = 1) {
    const NaiveUnion grown(atoms, growth_of(options));
    const double half_width = half_width_of(options);
    const double p = options.kind == MolecularSurface::Excluded ? options.probe_radius_world : 0;
    Random random(7);
    for (const auto& [x, value] : all_samples(molecular_surface(atoms, options), atoms, options)) {
        if (fraction < 1 && random.uniform(0, 1) > fraction) continue;
        const double height = grown.height(x);
        double expected = p + height;
        if (height < 0) {
            const double inner = p + half_width;
            const auto nearest = grown.nearest_outside(x, inner + 1e-3);
            expected = nearest ? p - (*nearest - x).norm() : -half_width;
            if (nearest && expected > 0) {
                const Vec3d y = *nearest + p * (x - *nearest).normalized();
                // 1e-7: what is less deep in another probe is the oracle's rounding; it would
                // change the distance by as little.
                if (-grown.distance(y, 2 * p) < p - 1e-7) {
                    ASSERT_GE(value, std::min(expected, half_width) - float_rounding);
                    if (cusps == nullptr || random.uniform(0, 1) > cusps->fraction) continue;
                    ++cusps->compared;
                    constexpr double tolerance = 2e-3;
                    const Bounds bounds =
                        distance_to_excluded_surface(grown, p, x, half_width, tolerance);
                    ASSERT_GE(value, bounds.lower - float_rounding) << x.transpose();
                    ASSERT_LE(value, bounds.upper + float_rounding) << x.transpose();
                    cusps->loose += bounds.upper - bounds.lower > 0.05;
                    continue;
                }
            }
        }
        expected = std::clamp(expected, -half_width, half_width);
        ASSERT_NEAR(value, expected, float_rounding) << x.transpose();
    }
}

constexpr std::array all_kinds = {MolecularSurface::VanDerWaals, MolecularSurface::Accessible,
                                  MolecularSurface::Excluded};

void expect_brute_force_in_all_kinds(const std::vector<Sphere>& atoms, double voxel_size = 0.4,
                                     CuspCheck* cusps = nullptr, double fraction = 1) {
    for (const auto kind : all_kinds)
        expect_brute_force(atoms, {.kind = kind, .voxel_size_world = voxel_size}, cusps, fraction);
}

std::vector<Sphere> random_molecule(Random& random, int count, double half) {
    std::vector<Sphere> atoms;
    for (int i = 0; i < count; ++i)
        atoms.push_back(
            {.centre_world = random.in_cube(half), .radius_world = random.uniform(1, 2)});
    return atoms;
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

TEST(MolecularSurface, FarAtomsDoNotKnowOfEachOther) {
    // 9 apart: no probe touches both, 1.6 + 1.7 + 2 * 1.4 = 6.1, and no band reaches the other.
    const std::vector<Sphere> atoms = {ball(0, 0, 0, 1.6), ball(9, 0.2, 0.1, 1.7)};
    expect_is(atoms, {.voxel_size_world = 0.25}, [&](const Vec3d& p) {
        return std::min(p.norm() - 1.6, (p - atoms[1].centre_world).norm() - 1.7);
    });
}

/// Two atoms and the torus between them, in a plane through their axis.
class TwoAtoms {
public:
    TwoAtoms(const std::vector<Sphere>& atoms) : a_(atoms[0]), b_(atoms[1]) {
        const Vec3d ab = b_.centre_world - a_.centre_world;
        length_ = ab.norm();
        axis_ = ab / length_;
        const double ra = a_.radius_world + probe, rb = b_.radius_world + probe;
        along_ = (length_ * length_ + ra * ra - rb * rb) / (2 * length_);
        circle_ = std::sqrt(ra * ra - along_ * along_);
    }
    bool has_cusps() const { return circle_ < probe; }

    /// The distance to the excluded surface.
    double distance(const Vec3d& p) const {
        const double z = (p - a_.centre_world).dot(axis_);
        const double r = (p - a_.centre_world - z * axis_).norm();
        const double from_a = std::hypot(r, z) - a_.radius_world;
        const double from_b = std::hypot(r, z - length_) - b_.radius_world;
        // Above the lines from the centres to the probe's, at (along_, circle_).
        const bool is_at_a = z * circle_ < r * along_;
        const bool is_at_b = (length_ - z) * circle_ < r * (length_ - along_);
        if ((from_a >= probe && from_b >= probe) || (is_at_a && is_at_b))
            return std::min(from_a, from_b);
        if (is_at_a) return from_a;
        if (is_at_b) return from_b;
        const double dz = z - along_, dr = r - circle_;
        const double to_torus = probe - std::hypot(dz, dr);
        // Within the probe, where its sphere beyond is across the axis: the tips are nearest.
        const double tip = std::sqrt(std::max(0.0, probe * probe - circle_ * circle_));
        if (to_torus > 0 && has_cusps() && circle_ + dr / std::hypot(dz, dr) * probe < 0)
            return std::hypot(r, std::abs(dz) - tip);
        return to_torus;
    }

private:
    Sphere a_, b_;
    double length_, along_, circle_;
    Vec3d axis_;
};

TEST(MolecularSurface, BetweenTwoAtomsIsATorus) {
    const std::vector<Sphere> atoms = {ball(0.1, 0.2, 0.3, 1.6), ball(2.1, 1.7, -1.7, 1.8)};
    const TwoAtoms two(atoms);
    EXPECT_FALSE(two.has_cusps());
    expect_is(atoms, {.voxel_size_world = 0.2, .half_width_voxels = 5},
              [&](const Vec3d& p) { return two.distance(p); });
}

TEST(MolecularSurface, BetweenTwoAtomsThatPartIsATorusWithCusps) {
    // 5.6 apart: the probe's centre comes nearer to the axis than its radius.
    const std::vector<Sphere> atoms = {ball(0, 0, 0, 1.6), ball(5.6 * 0.6, 5.6 * 0.8, 0, 1.8)};
    const TwoAtoms two(atoms);
    EXPECT_TRUE(two.has_cusps());
    expect_is(atoms, {.voxel_size_world = 0.1, .half_width_voxels = 9},
              [&](const Vec3d& p) { return two.distance(p); });
    // The axis along samples: all of the circle is as near.
    const std::vector<Sphere> along = {ball(0, 0, 0, 1.7), ball(5.75, 0, 0, 1.7)};
    const TwoAtoms again(along);
    EXPECT_TRUE(again.has_cusps());
    expect_is(along, {.voxel_size_world = 0.125, .half_width_voxels = 8},
              [&](const Vec3d& p) { return again.distance(p); });
}

TEST(MolecularSurface, TwoProbesInTheHoleOfThreeAtomsMeetInACircle) {
    // The probes touch all three from both sides, at height 0.7; they meet in a circle about the
    // middle, which the surface keeps: p - dist(x, A) would be 0.7 there, too little.
    const double height = 0.7, grown = 3.0;
    const double from_middle = std::sqrt(grown * grown - height * height);
    std::vector<Sphere> atoms;
    for (int i = 0; i < 3; ++i) {
        const double t = 2 * std::numbers::pi * i / 3;
        atoms.push_back(
            ball(from_middle * std::cos(t), from_middle * std::sin(t), 0, grown - probe));
    }
    const SparseField field = molecular_surface(atoms, {});
    EXPECT_NEAR(sample(field, {0, 0, 0}), std::sqrt(probe * probe - height * height),
                float_rounding);
    CuspCheck cusps;
    expect_brute_force(atoms, {.voxel_size_world = 0.25, .half_width_voxels = 6}, &cusps);
    EXPECT_GT(cusps.compared, 10);
    EXPECT_LT(cusps.loose, cusps.compared / 5);
}

// ------------------------------------------------------------------------------- brute force

TEST(MolecularSurface, RandomMoleculesAreAsBruteForceSays) {
    Random random(1);
    CuspCheck cusps;
    for (int n = 0; n < 36; ++n) {
        const double half = 1.5 + 0.25 * (n % 12); // dense ones and loose ones
        expect_brute_force_in_all_kinds(random_molecule(random, 2 + n % 7, half), 0.4, &cusps);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(cusps.compared, 100);
    EXPECT_LT(cusps.loose, cusps.compared / 10);
}

TEST(MolecularSurface, NoProbeReachesDeeperThanTheFieldSays) {
    // Probes at points of spheres, by the definition: no circles, no points of three.
    Random random(2);
    const std::vector<Sphere> atoms = random_molecule(random, 7, 2.5);
    std::vector<Vec3d> centres;
    for (int i = 0; i < 4000; ++i) {
        const Sphere& atom = atoms[std::size_t(i) % atoms.size()];
        const Vec3d a = atom.centre_world + (atom.radius_world + probe) * random.unit();
        if (std::ranges::all_of(atoms, [&](const Sphere& s) {
                return (a - s.centre_world).norm() >= s.radius_world + probe - 1e-12;
            }))
            centres.push_back(a);
    }
    EXPECT_GT(centres.size(), 500U);
    for_each_sample(molecular_surface(atoms, {}), [&](const Vec3d& p, double value, bool) {
        for (const Vec3d& a : centres)
            ASSERT_GE(value, std::min(probe - (p - a).norm(), 1.5) - float_rounding)
                << p.transpose();
    });
}

TEST(MolecularSurface, ExcludedIsADistanceByBranchAndBound) {
    // On both sides, whatever formulas say: some samples of each molecule.
    Random random(12);
    int inside = 0, outside = 0;
    for (int n = 0; n < 10; ++n) {
        const std::vector<Sphere> atoms = random_molecule(random, 3 + n % 4, 2);
        const NaiveUnion grown(atoms, probe);
        const MolecularSurfaceOptions options;
        for_each_sample(molecular_surface(atoms, options), [&](const Vec3d& p, double value,
                                                               bool is_active) {
            if (!is_active || random.uniform(0, 1) > 0.01) return;
            ++(value < 0 ? inside : outside);
            constexpr double tolerance = 2e-3;
            const Bounds bounds =
                distance_to_excluded_surface(grown, probe, p, half_width_of(options), tolerance);
            ASSERT_GE(std::abs(value), bounds.lower - float_rounding);
            ASSERT_LE(std::abs(value), bounds.upper + float_rounding);
        });
    }
    EXPECT_GT(inside, 30);
    EXPECT_GT(outside, 30);
}

TEST(ProbeCuts, TheNearestPointOutsideIsBruteForces) {
    Random random(3);
    int found = 0;
    for (int n = 0; n < 300; ++n) {
        ProbeCuts cuts(1.4, 1e-12);
        std::vector<Sphere> balls;
        for (int i = 0; i < 8; ++i) {
            const Vec3d centre = (i == 0 ? 1.3 : 2) * random.unit() * random.uniform(0, 1);
            balls.push_back({.centre_world = centre, .radius_world = 1.4});
            cuts.add(centre);
            const auto nearest = NaiveUnion(balls, 0).nearest_outside(Vec3d::Zero(), 10);
            ASSERT_TRUE(nearest.has_value());
            // 1e-6: the oracle's slack of 1e-9 moves points of three spheres that touch by its
            // root.
            ASSERT_NEAR(cuts.nearest().distance, nearest->norm(), 1e-6) << n << ", " << i;
            ++found;
        }
    }
    EXPECT_EQ(found, 2400);
}

// --------------------------------------------------------------------------------- invariants

/// From each sample to the next along each axis, beyond the band and across blocks, too.
void expect_changes_by_no_more_than_the_way(const SparseField& field) {
    const IndexBox box = dilated(field.extent(), 1, 1);
    std::vector<float> values(std::size_t(box.sample_count()));
    field.copy_box(box, 0, values);
    const Index3 n = box.size();
    const std::array<std::size_t, 3> strides = {1, std::size_t(n.x()),
                                                std::size_t(n.x()) * std::size_t(n.y())};
    double greatest = 0;
    std::size_t i = 0;
    for (int z = 0; z < n.z(); ++z)
        for (int y = 0; y < n.y(); ++y)
            for (int x = 0; x < n.x(); ++x, ++i) {
                const std::array<bool, 3> has_next = {x + 1 < n.x(), y + 1 < n.y(), z + 1 < n.z()};
                for (std::size_t k = 0; k < 3; ++k)
                    if (has_next[k])
                        greatest = std::max(
                            greatest, std::abs(double(values[i + strides[k]]) - double(values[i])));
            }
    EXPECT_LE(greatest, field.space().voxel_size_world() + float_rounding);
}

TEST(MolecularSurface, ExcludedLiesBetweenVanDerWaalsAndAccessible) {
    Random random(4);
    for (int n = 0; n < 4; ++n) {
        const std::vector<Sphere> atoms = random_molecule(random, 40, 6);
        // A half width that holds both others.
        const MolecularSurfaceOptions options{.half_width_voxels = 6};
        std::array<std::vector<std::pair<Vec3d, double>>, 3> samples;
        for (std::size_t k = 0; k < 3; ++k) {
            MolecularSurfaceOptions of_kind = options;
            of_kind.kind = all_kinds[k];
            samples[k] = all_samples(molecular_surface(atoms, of_kind), atoms, options);
        }
        for (std::size_t i = 0; i < samples[0].size(); ++i) {
            ASSERT_LE(samples[1][i].second, samples[2][i].second + float_rounding);
            ASSERT_LE(samples[2][i].second, samples[0][i].second + float_rounding);
            // The accessible surface is that of van der Waals' grown by the probe: farther from it
            // outside by the radius.
            if (samples[1][i].second > 0 && samples[0][i].second < 3) {
                ASSERT_NEAR(samples[1][i].second + probe, samples[0][i].second, 2 * float_rounding);
            }
        }
    }
}

TEST(MolecularSurface, ChangesByNoMoreThanTheWay) {
    Random random(5);
    for (const auto kind : all_kinds)
        expect_changes_by_no_more_than_the_way(molecular_surface(
            random_molecule(random, 60, 7), {.kind = kind, .voxel_size_world = 0.25}));
}

TEST(MolecularSurface, APointAsProbeLeavesVanDerWaals) {
    Random random(6);
    const std::vector<Sphere> atoms = random_molecule(random, 30, 5);
    const SparseField spheres = molecular_surface(atoms, {.kind = MolecularSurface::VanDerWaals});
    for (const auto kind : {MolecularSurface::Accessible, MolecularSurface::Excluded}) {
        const SparseField field = molecular_surface(atoms, {.kind = kind, .probe_radius_world = 0});
        ASSERT_EQ(field.blocks().size(), spheres.blocks().size());
        for (std::size_t b = 0; b < field.blocks().size(); ++b)
            EXPECT_EQ(field.blocks()[b].values, spheres.blocks()[b].values);
    }
    // With a small probe it is near: where spheres of radius r touch, the probe comes to
    // sqrt(2 r p) from the point, 0.063 for r = 2, and no less near elsewhere.
    const double small = 1e-3;
    const SparseField field = molecular_surface(atoms, {.probe_radius_world = small});
    const auto samples = all_samples(spheres, atoms, {});
    const auto others = all_samples(field, atoms, {});
    for (std::size_t i = 0; i < samples.size(); ++i) {
        ASSERT_LE(others[i].second, samples[i].second + float_rounding);
        ASSERT_GE(others[i].second, samples[i].second - 0.063 - small);
    }
}

/// The stored blocks without those of the molecule's place in the world.
void expect_same_but_moved(const SparseField& a, const SparseField& b, const Index3& blocks) {
    ASSERT_EQ(a.blocks().size(), b.blocks().size());
    for (std::size_t i = 0; i < a.blocks().size(); ++i) {
        ASSERT_EQ((a.blocks()[i].coordinate + blocks).eval(), b.blocks()[i].coordinate);
        for (std::size_t k = 0; k < samples_per_block; ++k)
            ASSERT_NEAR(a.blocks()[i].values[k], b.blocks()[i].values[k], float_rounding);
    }
}

TEST(MolecularSurface, PlaceAndOrderDoNotMatter) {
    Random random(8);
    std::vector<Sphere> atoms = random_molecule(random, 20, 4);
    // Eighths: exact at a distance of 2^40, too.
    for (Sphere& s : atoms) s.centre_world = (s.centre_world * 8).array().round().matrix() / 8;
    const SparseField here = molecular_surface(atoms, {});
    std::vector<Sphere> others(atoms.rbegin(), atoms.rend());
    others.insert(others.end(), atoms.begin(), atoms.end()); // each twice
    expect_same_but_moved(here, molecular_surface(others, {}), {0, 0, 0});
    others = atoms;
    for (Sphere& s : others) s.centre_world += Vec3d(40, -80, 12);
    expect_same_but_moved(here, molecular_surface(others, {}), {10, -20, 3});
    others = atoms;
    const double far = 0x1p40;
    for (Sphere& s : others) s.centre_world.x() += far;
    const SparseField there = molecular_surface(others, {});
    // Its lattice is shifted by whole voxels, not blocks.
    EXPECT_EQ(here.active_voxel_count(), there.active_voxel_count());
    double sum = 0, far_sum = 0;
    for_each_sample(here, [&](const Vec3d& p, double v, bool a) {
        if (a) sum += v * p.x();
    });
    for_each_sample(there, [&](const Vec3d& p, double v, bool a) {
        if (a) far_sum += v * (p.x() - far);
    });
    EXPECT_NEAR(sum, far_sum, 1e-3); // of some 10^5 floats of 1e-7
}

TEST(MolecularSurface, BlocksHoldTheBandAndNothingElse) {
    Random random(9);
    const std::vector<Sphere> atoms = random_molecule(random, 50, 6);
    for (const auto kind : all_kinds) {
        const SparseField field = molecular_surface(atoms, {.kind = kind, .half_width_voxels = 2});
        EXPECT_EQ(field.outside(), Outside::SignedBackground);
        EXPECT_EQ(field.half_width_world(), 1.0);
        for (const FieldBlock& block : field.blocks()) EXPECT_TRUE(block.active.any());
        for_each_sample(field, [](const Vec3d&, double value, bool is_active) {
            if (is_active) {
                ASSERT_LE(std::abs(value), 1);
            } else {
                ASSERT_EQ(std::abs(value), 1);
            }
        });
    }
}

// --------------------------------------------------------------------------- degenerate molecules

class Degenerate : public ::testing::TestWithParam<std::pair<const char*, std::vector<Sphere>>> {};

TEST_P(Degenerate, IsAsBruteForceSays) {
    CuspCheck cusps{.fraction = 0.1};
    expect_brute_force_in_all_kinds(GetParam().second, 0.5, &cusps);
}

std::vector<Sphere> ring(int count, double radius, double atom_radius) {
    std::vector<Sphere> atoms;
    for (int i = 0; i < count; ++i) {
        const double t = 2 * std::numbers::pi * i / count;
        atoms.push_back(ball(radius * std::cos(t), radius * std::sin(t), 0, atom_radius));
    }
    return atoms;
}

std::vector<Sphere> tetrahedron(double half_edge, double atom_radius) {
    const double h = half_edge;
    return {ball(h, h, h, atom_radius), ball(h, -h, -h, atom_radius), ball(-h, h, -h, atom_radius),
            ball(-h, -h, h, atom_radius)};
}

std::vector<Sphere> cubic(int n, double step, double atom_radius) {
    std::vector<Sphere> atoms;
    for (int i = 0; i < n * n * n; ++i)
        atoms.push_back(ball(step * (i % n), step * (i / n % n), step * (i / n / n), atom_radius));
    return atoms;
}

const double root3 = std::sqrt(3.0);

INSTANTIATE_TEST_SUITE_P(
    Molecules, Degenerate,
    ::testing::Values(
        std::pair("TwiceTheSame", std::vector{ball(0, 0, 0, 1.5), ball(0, 0, 0, 1.5)}),
        std::pair("NearlyTheSame", std::vector{ball(0, 0, 0, 1.5), ball(1e-13, 0, 0, 1.5)}),
        std::pair("AlmostTheSame",
                  std::vector{ball(0, 0, 0, 1.5), ball(1e-9, 0, 0, 1.5), ball(0, 1e-7, 0, 1.5)}),
        std::pair("OneInAnother", std::vector{ball(0, 0, 0, 2), ball(0.3, 0.2, 0, 1)}),
        std::pair("TouchingFromWithin", std::vector{ball(0, 0, 0, 2), ball(1, 0, 0, 1)}),
        std::pair("NearlyTouchingFromWithin",
                  std::vector{ball(0, 0, 0, 2), ball(1 + 1e-10, 0, 0, 1), ball(0, 1 + 1e-6, 0, 1)}),
        std::pair("Touching", std::vector{ball(0, 0, 0, 1.5), ball(3.5, 0, 0, 2)}),
        std::pair("GrownTouching", std::vector{ball(0, 0, 0, 1.5), ball(0, 6.3, 0, 2)}),
        std::pair("NearlyTouching", std::vector{ball(0, 0, 0, 1.5), ball(3.5 - 1e-12, 0, 0, 2),
                                                ball(0, 3.5 - 1e-7, 0, 2)}),
        std::pair("OneCircleOfThree",
                  std::vector{ball(-1, 0, 0, std::sqrt(3.25)), ball(0, 0, 0, 1.5),
                              ball(1, 0, 0, std::sqrt(3.25))}),
        std::pair("InALine", std::vector{ball(0, 0, 0, 1.5), ball(2, 0, 0, 1.5), ball(4, 0, 0, 1.5),
                                         ball(7, 0, 0, 1.5)}),
        std::pair("FourInASquareThroughItsMiddle", ring(4, 1.5, 1.5)),
        std::pair("GrownSquareThroughItsMiddle", ring(4, 3, 1.6)),
        std::pair("HexagonInAPlane", ring(6, 2.8, 1.5)),
        std::pair("TetrahedronThroughItsMiddle", tetrahedron(1, root3)),
        std::pair("GrownTetrahedronThroughItsMiddle", tetrahedron(root3, 1.6)),
        std::pair("TetrahedronThatHoldsAProbe", tetrahedron(1.9, 1.6)),
        std::pair("CrystalThroughItsMiddles", cubic(2, 3, 1.5 * root3 - probe)),
        std::pair("CrystalOfTouchingAtoms", cubic(2, 3, 1.5))),
    [](const auto& param) { return std::string(param.param.first); });

TEST(MolecularSurface, ACavityIsOutside) {
    // A shell of atoms at 6: within it a probe has room of 2.9 about the middle.
    std::vector<Sphere> atoms;
    const int count = 80;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count, t = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const double r = std::sqrt(1 - z * z);
        atoms.push_back(ball(6 * r * std::cos(t), 6 * r * std::sin(t), 6 * z, 1.7));
    }
    const MolecularSurfaceOptions options{.half_width_voxels = 10};
    const SparseField field = molecular_surface(atoms, options);
    // From the middle to the nearest atom's sphere.
    EXPECT_NEAR(sample(field, {0, 0, 0}), 4.3, 1e-6);
    EXPECT_LT(sample(field, {12, 0, 0}), 0);
    EXPECT_GT(sample(field, {18, 0, 0}), 0);
    expect_brute_force(atoms, {}, nullptr, 0.02);
}

// ------------------------------------------------------------------------------ errors, limits

template<class Error>
std::string message_of(const std::function<void()>& work) {
    try {
        work();
    } catch (const Error& error) {
        return error.what();
    }
    return "nothing was thrown";
}

std::string refusal(const std::vector<Sphere>& atoms, const MolecularSurfaceOptions& options) {
    return message_of<InputError>([&] { (void)molecular_surface(atoms, options); });
}

TEST(MolecularSurfaceErrors, SayWhatIsWrong) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    const std::vector<Sphere> atom = {ball(0, 0, 0, 1)};
    EXPECT_EQ(refusal({}, {}), "no atoms: they have no surface");
    EXPECT_THAT(refusal({ball(0, 0, 0, 1), ball(nan, 0, 0, 1)}, {}), HasSubstr("sphere 1"));
    EXPECT_THAT(refusal({ball(0, 0, 0, 0)}, {}), HasSubstr("radius is 0"));
    for (const double voxel : {0.0, -1.0, nan, infinity})
        EXPECT_THAT(refusal(atom, {.voxel_size_world = voxel}), HasSubstr("voxel size"));
    for (const double width : {0.5, nan, infinity})
        EXPECT_THAT(refusal(atom, {.half_width_voxels = width}), HasSubstr("half width"));
    for (const double radius : {-1.0, nan, infinity})
        EXPECT_THAT(refusal(atom, {.probe_radius_world = radius}), HasSubstr("probe radius"));
    EXPECT_THAT(refusal(atom, {.voxel_size_world = 1e-45}), HasSubstr("32-bit"));
    EXPECT_THAT(refusal({ball(1e18, 0, 0, 1)}, {}), HasSubstr("from the origin"));
    EXPECT_THAT(message_of<ResourceError>(
                    [&] { (void)molecular_surface(atom, {.voxel_size_world = 1e-9}); }),
                HasSubstr("too small: the molecule would span"));
}

TEST(MolecularSurfaceErrors, MemoryIsRefusedWithWhatItWouldTake) {
    Random random(10);
    const std::vector<Sphere> atoms = random_molecule(random, 30, 5);
    for (const double voxel : {0.5, 0.1}) { // counted, and estimated first
        MolecularSurfaceOptions options{.voxel_size_world = voxel};
        const double bytes =
            double(molecular_surface(atoms, options).blocks().size() * sizeof(FieldBlock));
        // A block may be counted that turns out to hold no sample of the band: one in four at most.
        options.memory_bytes = 1.3 * bytes;
        EXPECT_GT(molecular_surface(atoms, options).blocks().size(), 0U);
        options.memory_bytes = 0.1 * bytes;
        const std::string message =
            message_of<ResourceError>([&] { (void)molecular_surface(atoms, options); });
        const auto at = message.find("about ");
        ASSERT_NE(at, std::string::npos) << message;
        const double said = std::stod(message.substr(at + 6)) * 0x1p20;
        EXPECT_THAT(message, HasSubstr("MiB"));
        EXPECT_GT(said, 0.7 * bytes);
        EXPECT_LT(said, 1.5 * bytes);
    }
    // Too much by far is refused before it is counted: 10^9 blocks would take minutes.
    const auto start = std::chrono::steady_clock::now();
    EXPECT_THAT(message_of<ResourceError>([&] {
                    (void)molecular_surface(atoms,
                                            {.voxel_size_world = 1e-4, .memory_bytes = 0x1p30});
                }),
                HasSubstr("1 GiB of memory"));
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

TEST(MolecularSurface, TellsHowFarItIsAndStops) {
    Random random(11);
    const std::vector<Sphere> atoms = random_molecule(random, 200, 12);
    std::atomic<int> calls = 0;
    std::atomic<bool> is_bad = false;
    (void)molecular_surface(atoms, {.voxel_size_world = 0.2}, [&](std::string_view, double done) {
        ++calls;
        if (!(done >= 0 && done <= 1)) is_bad = true;
    });
    EXPECT_GT(calls, 10);
    EXPECT_FALSE(is_bad);
    for (const int last : {1, 2, 5}) {
        std::atomic<int> count = 0;
        EXPECT_THROW((void)molecular_surface(atoms, {.voxel_size_world = 0.2},
                                             [&](std::string_view, double) {
                                                 if (++count >= last) throw Interrupted();
                                             }),
                     Interrupted);
    }
}

// --------------------------------------------------------------------------- files of the archive

std::vector<Sphere> atoms_of(const std::filesystem::path& path) {
    std::vector<Sphere> atoms;
    for (const Atom& atom : read_molecule(path).atoms)
        atoms.push_back({.centre_world = atom.position,
                         .radius_world = element_of(atom.element).van_der_waals_angstrom});
    return atoms;
}

TEST(MolecularSurface, AProteinIsAsBruteForceSays) {
    const auto path = std::filesystem::path(ISOCAST_SHARED_DATA) / "1l2y.pdb";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "1l2y.pdb is not there";
    const std::vector<Sphere> atoms = atoms_of(path);
    for (const auto kind : all_kinds) expect_brute_force(atoms, {.kind = kind}, nullptr, 0.003);
}
TEST(MolecularSurface, OfAToxinLiesBetweenTheOthersAndChangesByNoMoreThanTheWay) {
    const auto path = std::filesystem::path(ISOCAST_SHARED_DATA) / "1tii.pdb";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "1tii.pdb is not there";
    const std::vector<Sphere> atoms = atoms_of(path);
    std::array<std::unique_ptr<SparseField>, 3> fields;
    for (std::size_t k = 0; k < 3; ++k) {
        fields[k] = std::make_unique<SparseField>(molecular_surface(atoms, {.kind = all_kinds[k]}));
        expect_changes_by_no_more_than_the_way(*fields[k]);
    }
    for_each_sample(*fields[2], [&, i = 0](const Vec3d& p, double value, bool) mutable {
        if (i++ % 7 != 0) return; // each sample() is a search
        const Index3 at = (p * 2).array().round().cast<int>();
        ASSERT_LE(sample(*fields[1], at), value + float_rounding);
        ASSERT_GE(sample(*fields[0], at), value - float_rounding);
    });
}

} // namespace
} // namespace isocast
