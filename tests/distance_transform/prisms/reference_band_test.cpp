// The thesis's methods against the exact transform and against other oracles.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/reference_band.h"

#include "distance_transform/brute_force.h"
#include "distance_transform/csc.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/printed_prisms.h"
#include "distance_transform/sample_meshes.h"
#include "fields.h"
#include "meshes.h"
#include "volume/errors.h"

#include <tbb/global_control.h>

namespace isocast::test {
namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

struct Case {
    CheckedMesh mesh;
    double voxel;
    double half_width;
    LatticeMesh lattice;

    Case(const Mesh& input, int resolution, double half_width_voxels)
        : mesh(check(input)), voxel(voxel_size_for_resolution(bounding_box(mesh.mesh), resolution)),
          half_width(half_width_voxels), lattice(on_lattice(mesh.mesh, voxel, half_width)) {}

    SparseField field_of(ReferenceBand band) const {
        for (FieldBlock& block : band.blocks) block.coordinate += lattice.anchor / block_size;
        return {lattice.space, half_width * voxel, Outside::SignedBackground,
                std::move(band.blocks)};
    }
    BandErrors errors_of(ReferenceBand band) const {
        const ConvertResult exact = convert(mesh, {.voxel_size_world = voxel,
                                                   .half_width_voxels = half_width,
                                                   .sign = SignMethod::Normal});
        const auto blocks = [](const SparseField& field) {
            return std::vector<FieldBlock>(field.blocks().begin(), field.blocks().end());
        };
        return band_errors(blocks(exact.field), blocks(field_of(std::move(band))), voxel);
    }
};

void expect_none(const BandErrors& errors) {
    EXPECT_GT(errors.samples, 0);
    EXPECT_EQ(errors.missing, 0);
    EXPECT_EQ(errors.too_far, 0);
    EXPECT_EQ(errors.extra, 0);
    EXPECT_EQ(errors.wrong_signs, 0);
}

TEST(PrintedPrisms, HoldTheWholeBandOfAFineSphere) {
    for (const double half_width : {3.0, 10.0}) {
        const Case sphere(sample_mesh("sphere6"), 64, half_width);
        expect_none(sphere.errors_of(
            scan_convert_prisms(sphere.lattice, half_width, Gaps::Leave, no_limit)));
    }
}

TEST(PrintedPrisms, HoldTheWholeBandOfACube) {
    const Case solid(cube(), 20, 4.0);
    const SparseField field =
        solid.field_of(scan_convert_prisms(solid.lattice, 4.0, Gaps::Leave, no_limit));
    // The cube's own formula: the voxel is 0.1.
    const Comparison comparison = compare(field, [](const Vec3d& p) {
        const Vec3d q = p.cwiseAbs() - Vec3d::Ones();
        return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
    });
    expect_exact(comparison);
    expect_none(solid.errors_of(scan_convert_prisms(solid.lattice, 4.0, Gaps::Leave, no_limit)));
}

TEST(PrintedPrisms, ErrInsideConvexSolidsNowhere) {
    // Inside a convex solid the closest face is that of the nearest plane, and the bisector planes
    // are where two planes are equally near: each sample is in the prism of its closest face.
    std::mt19937 random(9);
    for (int round = 0; round < 10; ++round) {
        const Case hull(random_hull(12 + 10 * round, random), 40, 5.0);
        const ConvertResult exact =
            convert(hull.mesh, {.voxel_size_world = hull.voxel, .half_width_voxels = 5});
        const auto found =
            band_map(hull.field_of(scan_convert_prisms(hull.lattice, 5.0, Gaps::Leave, no_limit)));
        for (const auto& [index, value] : band_map(exact.field)) {
            if (value >= 0) continue;
            const auto at = found.find(index);
            ASSERT_NE(at, found.end());
            // 1e-5 voxel as everywhere, the float's own rounding included.
            ASSERT_NEAR(at->second, value, 1e-5 * hull.voxel);
        }
    }
}

TEST(PrintedPrisms, AreNotConservativeOutsideConvexSolidsAlthoughNoGapIsThere) {
    // Near a vertex the bisector plane to a third face can cut off points whose closest feature is
    // the edge of the other two.
    std::mt19937 random(9);
    const Case hull(random_hull(100, random), 48, 12.0);
    EXPECT_EQ(Prisms(hull.mesh.mesh, hull.voxel, Gaps::Leave).counts().gaps, 0);
    const BandErrors errors =
        hull.errors_of(scan_convert_prisms(hull.lattice, 12.0, Gaps::Leave, no_limit));
    EXPECT_GT(errors.too_far, 0);
    EXPECT_EQ(errors.extra, 0);
}

TEST(PrintedPrisms, HaveTheRightSignWhereverTheirDistanceIsRight) {
    std::mt19937 random(12);
    int compared = 0;
    for (int round = 0; round < 5; ++round) {
        const Case solid(random_spiky_solid(40 + 40 * round, random), 40, 6.0);
        const ConvertResult exact = convert(
            solid.mesh,
            {.voxel_size_world = solid.voxel, .half_width_voxels = 6, .sign = SignMethod::Normal});
        const auto found =
            band_map(solid.field_of(scan_convert_prisms(solid.lattice, 6, Gaps::Close, no_limit)));
        for (const auto& [index, value] : band_map(exact.field)) {
            const auto at = found.find(index);
            if (at == found.end() || std::abs(value) < 1e-9 * solid.voxel) continue;
            // Another feature at nearly the same distance may lie on the other side: only samples
            // with the same distance, to the float's rounding, tell.
            if (std::abs(std::abs(at->second) - std::abs(value)) > ulp(value)) continue;
            ++compared;
            ASSERT_EQ(std::signbit(at->second), std::signbit(value));
        }
    }
    EXPECT_GT(compared, 10000);
}

TEST(PrintedPrisms, LoseSomeOfTheBunnysBandAndNeverComeTooNear) {
    const auto path = shared_data("bunny-closed.obj");
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
    const Case bunny(read_mesh(path), 128, 3.0);
    const BandErrors left =
        bunny.errors_of(scan_convert_prisms(bunny.lattice, 3.0, Gaps::Leave, no_limit));
    const BandErrors closed =
        bunny.errors_of(scan_convert_prisms(bunny.lattice, 3.0, Gaps::Close, no_limit));
    // A distance to some triangles is never below the distance to all.
    EXPECT_EQ(left.extra, 0);
    EXPECT_EQ(closed.extra, 0);
    // The prisms as printed are not conservative; closing gaps can only help.
    EXPECT_GT(closed.too_far, 0);
    EXPECT_LT(closed.missing, left.missing);
    EXPECT_LE(closed.missing + closed.too_far, left.missing + left.too_far);
    // 0.5 %: 0.28 % here; ten times that would be a lost plane or a lost block.
    EXPECT_LT(left.missing + left.too_far, left.samples / 200);
}

TEST(PrintedPrisms, DoNotDependOnTheNumberOfThreads) {
    const Case knot(sample_mesh("knot"), 48, 3.0);
    const auto run_on = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return scan_convert_prisms(knot.lattice, 3.0, Gaps::Close, no_limit);
    };
    const ReferenceBand one = run_on(1);
    const ReferenceBand two = run_on(2);
    EXPECT_EQ(one.distance_evaluations, two.distance_evaluations);
    ASSERT_EQ(one.blocks.size(), two.blocks.size());
    for (std::size_t i = 0; i < one.blocks.size(); ++i) {
        EXPECT_EQ(one.blocks[i].coordinate, two.blocks[i].coordinate);
        EXPECT_EQ(one.blocks[i].values, two.blocks[i].values);
        EXPECT_EQ(one.blocks[i].active, two.blocks[i].active);
    }
}

TEST(Csc, IsExactOnACube) {
    const Case solid(cube(), 20, 4.0);
    const SparseField field =
        solid.field_of(characteristics_scan_conversion(solid.lattice, 4.0, no_limit));
    const Comparison comparison = compare(field, [&](const Vec3d& p) {
        const double distance = brute_force_distance(solid.mesh.mesh, p);
        return p.cwiseAbs().maxCoeff() < 1 ? -distance : distance;
    });
    EXPECT_LE(comparison.worst_error_voxels, scan_slack);
    EXPECT_EQ(comparison.wrong_signs, 0);
    expect_none(solid.errors_of(characteristics_scan_conversion(solid.lattice, 4.0, no_limit)));
}

TEST(Csc, IsExactOnTheSampleMeshes) {
    for (const std::string& name : sample_mesh_names()) {
        const Case sample(sample_mesh(name), 48, 4.0);
        const SparseField field =
            sample.field_of(characteristics_scan_conversion(sample.lattice, 4.0, no_limit));
        const CgalOracle oracle(sample.mesh.mesh);
        const Comparison comparison =
            compare(field, [&](const Vec3d& p) { return oracle.signed_distance(p); });
        EXPECT_LE(comparison.worst_error_voxels, scan_slack) << name;
        EXPECT_EQ(comparison.wrong_signs, 0) << name;
        expect_none(
            sample.errors_of(characteristics_scan_conversion(sample.lattice, 4.0, no_limit)));
    }
}

TEST(Csc, IsExactAndSignedRightOnSpikySolids) {
    std::mt19937 random(10);
    for (int round = 0; round < 20; ++round) {
        const Case solid(random_spiky_solid(20 + 10 * round, random), 40, 6.0);
        expect_none(solid.errors_of(characteristics_scan_conversion(solid.lattice, 6.0, no_limit)));
    }
}

TEST(Csc, IsExactOnTheBunny) {
    const auto path = shared_data("bunny-closed.obj");
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
    const Case bunny(read_mesh(path), 128, 3.0);
    expect_none(bunny.errors_of(characteristics_scan_conversion(bunny.lattice, 3.0, no_limit)));
}

TEST(ReferenceBand, NeedsAClosedMesh) {
    Mesh open = cube();
    open.triangles.pop_back();
    const Case solid(open, 20, 3.0);
    EXPECT_THROW(scan_convert_prisms(solid.lattice, 3.0, Gaps::Close, no_limit), InputError);
    EXPECT_THROW(characteristics_scan_conversion(solid.lattice, 3.0, no_limit), InputError);
}

TEST(ReferenceBand, StopsWhenInterrupted) {
    const Case solid(cube(), 20, 3.0);
    const auto stop_in = [](std::string_view wanted) {
        return [wanted](std::string_view stage, double) {
            if (stage == wanted) throw Interrupted();
        };
    };
    EXPECT_THROW(scan_convert_prisms(solid.lattice, 3.0, Gaps::Close, no_limit, stop_in("prepare")),
                 Interrupted);
    EXPECT_THROW(
        scan_convert_prisms(solid.lattice, 3.0, Gaps::Close, no_limit, stop_in("transform")),
        Interrupted);
    EXPECT_THROW(
        characteristics_scan_conversion(solid.lattice, 3.0, no_limit, stop_in("transform")),
        Interrupted);
}

TEST(ReferenceBand, RefusesToTakeMoreMemoryThanGiven) {
    const Case solid(cube(), 20, 3.0);
    // The band of 20^3 voxels needs some 30 blocks of 2 KiB.
    constexpr double too_little = 20e3;
    EXPECT_THROW(scan_convert_prisms(solid.lattice, 3.0, Gaps::Close, too_little), ResourceError);
    EXPECT_THROW(characteristics_scan_conversion(solid.lattice, 3.0, too_little), ResourceError);
    EXPECT_FALSE(scan_convert_prisms(solid.lattice, 3.0, Gaps::Close, 1e6).blocks.empty());
    EXPECT_FALSE(characteristics_scan_conversion(solid.lattice, 3.0, 1e6).blocks.empty());
}

TEST(BandErrors, CountWhatWasChanged) {
    const Case solid(cube(), 20, 3.0);
    const FieldBlocks exact = scan_convert_prisms(solid.lattice, 3.0, Gaps::Leave, no_limit).blocks;
    ASSERT_GT(exact.size(), 3u);
    FieldBlocks changed = exact;
    const auto active_sample = [](const FieldBlock& block, double least) {
        for (int i = 0; i < samples_per_block; ++i)
            if (block.active[i] && std::abs(block.values[i]) > least) return i;
        return -1;
    };
    const int i = active_sample(changed[0], 0.05);
    ASSERT_GE(i, 0);
    changed[0].values[i] += static_cast<float>(std::copysign(0.02, changed[0].values[i]));
    const int j = active_sample(changed[1], 0.05);
    ASSERT_GE(j, 0);
    changed[1].values[j] = -changed[1].values[j];
    const auto lost = static_cast<std::int64_t>(changed[2].active.count());
    changed.erase(changed.begin() + 2);
    changed.push_back({.coordinate = Index3(100, 100, 100)});
    changed.back().active[5] = true;

    const BandErrors errors = band_errors(exact, changed, solid.voxel);
    EXPECT_EQ(errors.too_far, 1);
    EXPECT_NEAR(errors.worst_voxels, 0.2, 1e-5); // 0.02 of voxels of 0.1, in float
    EXPECT_EQ(errors.wrong_signs, 1);
    EXPECT_EQ(errors.missing, lost);
    EXPECT_EQ(errors.extra, 1);
    EXPECT_EQ(band_errors(exact, exact, solid.voxel).samples, errors.samples);
    expect_none(band_errors(exact, exact, solid.voxel));
}

} // namespace
} // namespace isocast::test
