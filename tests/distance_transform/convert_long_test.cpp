// Every sample of the band against every triangle: minutes.
// SPDX-License-Identifier: MPL-2.0
#include "cgal_oracle.h"
#include "distance_transform/brute_force.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "fields.h"

namespace isocast::test {
namespace {

void expect_brute_force_distances(const Mesh& raw) {
    const CheckedMesh mesh = check(raw);
    const CgalOracle oracle(mesh.mesh);
    const ConvertResult result = convert_at(mesh, 128);
    expect_exact(compare(result.field, [&](const Vec3d& p) {
        const double distance = brute_force_distance(mesh.mesh, p);
        return oracle.is_inside(p) ? -distance : distance;
    }));
}

class BruteForce : public ::testing::TestWithParam<std::string> {};

TEST_P(BruteForce, EverySampleAgreesWithEveryTriangle) {
    if (GetParam().ends_with(".obj")) {
        if (!std::filesystem::exists(shared_data(GetParam())))
            GTEST_SKIP() << GetParam() << " is not there";
        expect_brute_force_distances(read_mesh(shared_data(GetParam())));
    } else {
        expect_brute_force_distances(sample_mesh(GetParam()));
    }
}

INSTANTIATE_TEST_SUITE_P(FourMeshes, BruteForce,
                         ::testing::Values("sphere6", "knot", "bunny-closed.obj", "armadillo.obj"));

} // namespace
} // namespace isocast::test
