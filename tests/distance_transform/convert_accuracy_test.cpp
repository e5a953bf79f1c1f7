// Every sample of the band against independent oracles in double.
// SPDX-License-Identifier: MPL-2.0
#include "cgal_oracle.h"
#include "distance_transform/brute_force.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "fields.h"

namespace isocast::test {
namespace {

/// Distance by brute force, side by CGAL.
void expect_brute_force_distances(const std::string& name, int resolution) {
    const CheckedMesh mesh = check(sample_mesh(name));
    const CgalOracle oracle(mesh.mesh);
    const ConvertResult result = convert_at(mesh, resolution);
    EXPECT_EQ(result.sign_used, SignMethod::Normal);
    expect_exact(compare(result.field, [&](const Vec3d& p) {
        const double distance = brute_force_distance(mesh.mesh, p);
        return oracle.is_inside(p) ? -distance : distance;
    }));
}

void expect_tree_distances(const CheckedMesh& mesh, int resolution) {
    const CgalOracle oracle(mesh.mesh);
    const ConvertResult result = convert_at(mesh, resolution);
    EXPECT_EQ(result.sign_used, SignMethod::Normal);
    expect_exact(compare(result.field, [&](const Vec3d& p) { return oracle.signed_distance(p); }));
}

TEST(ConvertAccuracy, SphereAgreesWithCgal) {
    expect_tree_distances(check(sample_mesh("sphere6")), 128);
}

// At 128 the long tests do the same.
TEST(ConvertAccuracy, SphereAgreesWithBruteForce) {
    expect_brute_force_distances("sphere6", 40);
}

TEST(ConvertAccuracy, KnotAgreesWithBruteForce) {
    expect_brute_force_distances("knot", 128);
}

TEST(ConvertAccuracy, SeashellAgreesWithBruteForce) {
    expect_brute_force_distances("seashell", 64);
}

class RealMeshes : public ::testing::TestWithParam<std::pair<std::string, int>> {};

TEST_P(RealMeshes, AgreeWithCgal) {
    const auto& [file, resolution] = GetParam();
    if (!std::filesystem::exists(shared_data(file))) GTEST_SKIP() << file << " is not there";
    expect_tree_distances(check(read_mesh(shared_data(file))), resolution);
}

// Scans at 128; the CAD part has sharp edges and long thin triangles.
INSTANTIATE_TEST_SUITE_P(ConvertAccuracy, RealMeshes,
                         ::testing::Values(std::pair("bunny-closed.obj", 128),
                                           std::pair("armadillo.obj", 128),
                                           std::pair("fandisk.obj", 64),
                                           std::pair("rocker-arm.obj", 64),
                                           std::pair("3holes.off", 64), std::pair("spot.obj", 64)));

// Four pairs of triangles intersect, and normals gave ten samples the wrong sign there, two voxels
// from the surface: the contradiction must be noticed.
TEST(ConvertAccuracy, HorseThatIntersectsItselfAgreesWithCgal) {
    if (!std::filesystem::exists(shared_data("horse.ply"))) GTEST_SKIP() << "no horse.ply";
    const CheckedMesh mesh = check(read_mesh(shared_data("horse.ply")));
    const CgalOracle oracle(mesh.mesh);
    const ConvertResult result = convert_at(mesh, 64);
    EXPECT_EQ(result.sign_used, SignMethod::Winding);
    ASSERT_EQ(result.warnings.size(), 1u);
    EXPECT_THAT(result.warnings[0], ::testing::HasSubstr("intersects itself"));
    expect_exact(compare(result.field, [&](const Vec3d& p) { return oracle.signed_distance(p); }));
}

TEST(ConvertAccuracy, CowWithAPinchedVertexAndIntersectionsAgreesWithBruteForce) {
    if (!std::filesystem::exists(shared_data("cow.obj"))) GTEST_SKIP() << "no cow.obj";
    const CheckedMesh mesh = check(read_mesh(shared_data("cow.obj")));
    expect_exact(compare(convert_at(mesh, 40).field, [&](const Vec3d& p) {
        const double distance = brute_force_distance(mesh.mesh, p);
        return brute_force_winding_number(mesh.mesh, p) > 0.5 ? -distance : distance;
    }));
}

TEST(ConvertAccuracy, BandAndBlocksAreComplete) {
    const CheckedMesh mesh = check(sample_mesh("knot"));
    const CgalOracle oracle(mesh.mesh);
    const SparseField field = convert_at(mesh, 48).field;
    const double voxel = field.space().voxel_size_world();
    const WorldBox box = bounding_box(mesh.mesh);
    const IndexBox all = {(box.min / voxel).array().floor().cast<int>() - 6,
                          (box.max / voxel).array().ceil().cast<int>() + 6};
    std::vector<float> values(static_cast<std::size_t>(all.sample_count()));
    field.copy_box(all, 0, values);
    const auto active = band_map(field);
    const auto background = static_cast<float>(field.background_world());
    const Index3 size = all.size();
    std::atomic<int> wrong = 0;
    std::atomic<int> in_band = 0;
    tbb::parallel_for(0, static_cast<int>(values.size()), [&](int i) {
        const Index3 index =
            all.lo + Index3(i % size.x(), i / size.x() % size.y(), i / (size.x() * size.y()));
        const Vec3d p = field.space().to_world(index.cast<double>());
        const double distance_voxels = brute_force_distance(mesh.mesh, p) / voxel;
        const bool is_active = active.contains({index.z(), index.y(), index.x()});
        // 1e-8 voxel: on the very border of the band rounding may decide either way.
        if (distance_voxels < 3 - 1e-8 && !is_active) ++wrong;
        if (distance_voxels > 3 + 1e-8 && is_active) ++wrong;
        if (!is_active && std::abs(values[i]) != background) ++wrong;
        if (!is_active && (values[i] < 0) != oracle.is_inside(p)) ++wrong;
        if (distance_voxels < 3) ++in_band;
    });
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(in_band, 10000);
    for (const FieldBlock& block : field.blocks()) EXPECT_TRUE(block.active.any());
}

} // namespace
} // namespace isocast::test
