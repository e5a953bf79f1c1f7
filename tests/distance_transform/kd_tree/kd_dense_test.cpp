// Dense fields by the kD-tree, sample by sample, against brute force and CGAL.
// SPDX-License-Identifier: MPL-2.0
#include "../cgal_oracle.h"
#include "distance_transform/brute_force.h"
#include "distance_transform/checked_mesh.h"
#include "distance_transform/kd_dense.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "volume/errors.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <filesystem>

namespace isocast::test {
namespace {

/// About the mesh's middle, and not a multiple of the blocks' size.
IndexBox box_around(const LatticeMesh& lattice, int size) {
    const Index3 lo = lattice.anchor - Index3(size / 2, size / 2 - 1, size / 2 + 1);
    return {lo, lo + Index3(size, size + 3, size - 1)};
}

LatticeMesh on_lattice_at(const Mesh& mesh, int resolution) {
    return on_lattice(mesh, bounding_box(mesh).size().maxCoeff() / (resolution - 9), 3);
}

/// truth(p_voxels), a signed distance in voxels, at every sample.
template<class Truth>
std::vector<double> truth_in(const LatticeMesh& lattice, const IndexBox& box, const Truth& truth) {
    const Index3 size = box.size();
    std::vector<double> expected(static_cast<std::size_t>(box.sample_count()));
    tbb::parallel_for(std::size_t{0}, expected.size(), [&](std::size_t at) {
        const int i = static_cast<int>(at);
        const Index3 index =
            box.lo + Index3(i % size.x(), i / size.x() % size.y(), i / (size.x() * size.y()));
        expected[at] = truth((index - lattice.anchor).cast<double>());
    });
    return expected;
}

void expect_exact(const DenseField& field, std::span<const double> expected_voxels) {
    const double voxel = field.space().voxel_size_world();
    ASSERT_EQ(field.values().size(), expected_voxels.size());
    int wrong_distances = 0;
    int wrong_signs = 0;
    int inside = 0;
    for (std::size_t i = 0; i < expected_voxels.size(); ++i) {
        const double expected = expected_voxels[i];
        const double found = double{field.values()[i]} / voxel;
        // One rounding to float, and 1e-5 voxel, what the project promises.
        const double tolerance = 0x1p-24 * std::abs(expected) + 1e-5;
        if (!(std::abs(std::abs(found) - std::abs(expected)) <= tolerance)) ++wrong_distances;
        // 1e-9 voxel: nearer to the surface the oracle's own rounding decides.
        if (std::abs(expected) > 1e-9 && (found < 0) != (expected < 0)) ++wrong_signs;
        if (expected < 0) ++inside;
    }
    EXPECT_EQ(wrong_distances, 0);
    EXPECT_EQ(wrong_signs, 0);
    EXPECT_GT(inside, 100);
}

/// By both kinds of signs.
void expect_agreement_with_cgal(const Mesh& mesh, int resolution) {
    const LatticeMesh lattice = on_lattice_at(mesh, resolution);
    const CgalOracle oracle(lattice.mesh);
    const KdTree tree(lattice.mesh);
    KdDenseOptions options{.box = box_around(lattice, resolution)};
    const std::vector<double> expected =
        truth_in(lattice, options.box, [&](const Vec3d& p) { return oracle.signed_distance(p); });
    const MeshTopology topology = topology_of(lattice.mesh);
    expect_exact(dense_distances(lattice, topology, tree, options).field, expected);
    const WindingNumber winding(lattice.mesh, true);
    options.winding = &winding;
    expect_exact(dense_distances(lattice, topology, tree, options).field, expected);
}

TEST(KdDense, KnotAgreesWithBruteForce) {
    const LatticeMesh lattice = on_lattice_at(sample_mesh("knot"), 40);
    const CgalOracle oracle(lattice.mesh);
    const MeshTopology topology = topology_of(lattice.mesh);
    const IndexBox box = box_around(lattice, 40);
    const std::vector<double> expected = truth_in(lattice, box, [&](const Vec3d& p) {
        const double distance = brute_force_distance(lattice.mesh, p);
        return oracle.is_inside(p) ? -distance : distance;
    });
    for (const KdVariant variant : {KdVariant::Overlapping, KdVariant::SplitReferences})
        expect_exact(
            dense_distances(lattice, topology, KdTree(lattice.mesh, variant), {.box = box}).field,
            expected);
}

TEST(KdDense, SampleMeshesAgreeWithCgal) {
    for (const char* const name : {"sphere6", "torus", "seashell"})
        expect_agreement_with_cgal(check(sample_mesh(name)).mesh, 36);
}

class RealMeshes : public ::testing::TestWithParam<std::pair<std::string, int>> {};

TEST_P(RealMeshes, AgreeWithCgal) {
    const auto& [file, resolution] = GetParam();
    const auto path = std::filesystem::path(ISOCAST_SHARED_DATA) / file;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    expect_agreement_with_cgal(check(read_mesh(path)).mesh, resolution);
}

INSTANTIATE_TEST_SUITE_P(KdDense, RealMeshes,
                         ::testing::Values(std::pair("bunny-closed.obj", 64),
                                           std::pair("fandisk.obj", 48),
                                           std::pair("3holes.off", 40)));

// A far box, where thousands of triangles are nearly as close as the closest.
TEST(KdDense, FarBoxAgreesWithBruteForce) {
    const LatticeMesh lattice = on_lattice_at(sample_mesh("torus"), 40);
    const Index3 lo = lattice.anchor + Index3(300, -20, 77);
    const IndexBox box = {lo, lo + Index3(20, 19, 18)};
    const KdDenseResult result =
        dense_distances(lattice, topology_of(lattice.mesh), KdTree(lattice.mesh), {.box = box});
    std::size_t i = 0;
    for (int z = 0; z < 18; ++z)
        for (int y = 0; y < 19; ++y)
            for (int x = 0; x < 20; ++x, ++i) {
                const Vec3d p = (lo - lattice.anchor + Index3(x, y, z)).cast<double>();
                const double expected =
                    brute_force_distance(lattice.mesh, p) * lattice.space.voxel_size_world();
                ASSERT_FLOAT_EQ(result.field.values()[i], static_cast<float>(expected));
            }
}

// Open: the winding number passes 1/2 off the surface, in the hole.
TEST(KdDense, OpenMeshHasTheSignOfItsWindingNumber) {
    Mesh mesh = sample_mesh("torus");
    mesh.triangles.resize(mesh.triangles.size() * 9 / 10);
    const LatticeMesh lattice = on_lattice_at(mesh, 24);
    const WindingNumber winding(lattice.mesh, false);
    const KdDenseResult result =
        dense_distances(lattice, topology_of(lattice.mesh), KdTree(lattice.mesh),
                        {.box = box_around(lattice, 24), .winding = &winding});
    expect_exact(result.field, truth_in(lattice, result.field.extent(), [&](const Vec3d& p) {
                     const double distance = brute_force_distance(lattice.mesh, p);
                     return winding.is_inside(p) ? -distance : distance;
                 }));
}

TEST(KdDense, IsTheSameOnOneThread) {
    const LatticeMesh lattice = on_lattice_at(sample_mesh("seashell"), 40);
    const KdTree tree(lattice.mesh);
    const MeshTopology topology = topology_of(lattice.mesh);
    const KdDenseOptions options{.box = box_around(lattice, 40)};
    const KdDenseResult on_all = dense_distances(lattice, topology, tree, options);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const KdDenseResult on_one = dense_distances(lattice, topology, tree, options);
    EXPECT_TRUE(std::ranges::equal(on_all.field.values(), on_one.field.values()));
    EXPECT_EQ(on_all.distance_evaluations, on_one.distance_evaluations);
}

// A tile shares its sites: measured 12.1 distances a sample, all lanes counted.
TEST(KdDense, NeedsFewDistancesASample) {
    const LatticeMesh lattice = on_lattice_at(sample_mesh("knot"), 128);
    const IndexBox box = box_around(lattice, 128);
    const KdDenseResult result =
        dense_distances(lattice, topology_of(lattice.mesh), KdTree(lattice.mesh), {.box = box});
    EXPECT_LT(static_cast<double>(result.distance_evaluations),
              16 * static_cast<double>(box.sample_count()));
}

TEST(KdDense, RefusesWhatCannotBe) {
    const LatticeMesh lattice = on_lattice_at(sample_mesh("torus"), 24);
    const KdTree tree(lattice.mesh);
    const MeshTopology topology = topology_of(lattice.mesh);
    EXPECT_THROW(dense_distances(lattice, topology, tree, {}), InputError);
    const IndexBox box = box_around(lattice, 24);
    const double bytes = 4.0 * static_cast<double>(box.sample_count());
    EXPECT_NO_THROW(dense_distances(lattice, topology, tree, {.box = box, .memory_bytes = bytes}));
    EXPECT_THROW(dense_distances(lattice, topology, tree, {.box = box, .memory_bytes = bytes - 1}),
                 ResourceError);
    // Refused before allocation, though the count of samples passes 2^63.
    const Index3 greatest = Index3::Constant(greatest_index);
    EXPECT_THROW(dense_distances(lattice, topology, tree,
                                 {.box = {-greatest, greatest}, .memory_bytes = 1e15}),
                 ResourceError);
}

TEST(KdDense, ProgressCanStopIt) {
    const LatticeMesh lattice = on_lattice_at(sample_mesh("torus"), 24);
    const auto stop = [](std::string_view, double) { throw Interrupted(); };
    EXPECT_THROW(dense_distances(lattice, topology_of(lattice.mesh), KdTree(lattice.mesh),
                                 {.box = box_around(lattice, 24)}, stop),
                 Interrupted);
}

} // namespace
} // namespace isocast::test
