// Two hundred random solids, and all meshes at hand, every sample: minutes.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh_files.h"
#include "exact_field.h"
#include "random_solids.h"
#include "soup_oracle.h"

#include <filesystem>

namespace isocast::test {
namespace {

// In tens, so that a failing one is found again soon.
class ManyRandomSolids : public ::testing::TestWithParam<unsigned> {};

TEST_P(ManyRandomSolids, AreExact) {
    for (unsigned seed = GetParam(); seed < GetParam() + 10; ++seed) {
        SCOPED_TRACE(seed);
        if (seed < 150)
            expect_exact_conversion(noisy_sphere(seed, 3), 0.09);
        else
            expect_exact_conversion(overlapping_shells(seed), 0.08);
    }
}

INSTANTIATE_TEST_SUITE_P(RandomSolids, ManyRandomSolids, ::testing::Range(0U, 200U, 10U));

class AllMeshes : public ::testing::TestWithParam<std::tuple<std::string, int>> {};

// Sides are those of the winding number where the mesh is closed and oriented; of others `auto`
// says that it takes the winding number, and distances alone are compared.
TEST_P(AllMeshes, AreExactOrHaveAStatedVerdict) {
    const auto& [name, resolution] = GetParam();
    const std::filesystem::path path = std::filesystem::path(ISOCAST_SHARED_DATA) / name;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << name << " is not there";
    const CheckedMesh mesh = check(read_mesh(path));
    const bool is_closed = mesh.verdict.is_closed() && mesh.verdict.is_oriented();
    const ConvertResult result = convert(
        mesh, {.voxel_size_world = voxel_size_for_resolution(bounding_box(mesh.mesh), resolution)});
    if (!is_closed) {
        EXPECT_EQ(result.sign_used, SignMethod::Winding);
        EXPECT_FALSE(mesh.verdict.summary().empty());
        EXPECT_FALSE(result.warnings.empty());
    }
    const IndexBox box = box_about(mesh.mesh, result.field.space(), 3);
    const SoupOracle oracle(in_voxels(mesh.mesh, result.field.space(), box.lo));
    const KnownField known =
        known_field({.distance_near =
                         [&](const Vec3d&, double) {
                             return [&](const Vec3d& p) { return oracle.distance(p); };
                         },
                     .winding = [&](const Vec3d& p) { return double(oracle.winding_number(p)); },
                     .sides = is_closed ? Sides::Closed : Sides::None},
                    box, 3);
    expect_no_faults(faults_of(result.field, known, 3));
}

INSTANTIATE_TEST_SUITE_P(
    SharedData, AllMeshes,
    ::testing::Combine(::testing::Values("3holes.off", "armadillo.obj", "bumpy-cube.obj",
                                         "bunny-closed.obj", "cow.obj", "fandisk.obj", "horse.ply",
                                         "nefertiti.obj", "rocker-arm.obj", "spot.obj",
                                         "stanford-bunny.obj", "suzanne.obj", "teapot.obj",
                                         "truck.obj"),
                       ::testing::Values(64, 128, 256)),
    [](const auto& test) {
        std::string name =
            std::get<0>(test.param) + "_at_" + std::to_string(std::get<1>(test.param));
        std::ranges::replace_if(
            name, [](char c) { return c == '.' || c == '-'; }, '_');
        return name;
    });

} // namespace
} // namespace isocast::test
