// The pictures' prisms are closed solids with the volumes that they should have.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/checked_mesh.h"
#include "distance_transform/prism.h"

#include "meshes.h"

#include <gtest/gtest.h>

#include <numeric>

namespace isocast::test {
namespace {

Mesh all_prisms(const Mesh& mesh, double half_width) {
    std::vector<int> triangles(mesh.triangles.size());
    std::iota(triangles.begin(), triangles.end(), 0);
    return prism_mesh(mesh, Prisms(mesh, half_width, Gaps::Leave), triangles);
}

TEST(PrismMesh, OfACubeFillsTheSpaceBetweenTwoCubes) {
    // Bisectors of 45 degrees: from the cube of edge 2 - 2 h to that of edge 2 + 2 h; from h = 1 on
    // the inner one is the point where all prisms end.
    for (const double h : {0.25, 0.5, 1.0, 2.0}) {
        const double inner = std::max(0.0, 2 - 2 * h);
        // 1e-12: rounding of 36 prisms' worth of sums.
        EXPECT_NEAR(check(all_prisms(cube(), h)).verdict.volume_world,
                    std::pow(2 + 2 * h, 3) - std::pow(inner, 3), 1e-12 * std::pow(2 + 2 * h, 3))
            << h;
    }
}

TEST(PrismMesh, OfASaddleIsClosedBeforeAndAfterItsGapIs) {
    const Mesh mesh = saddle_of_eight();
    double volume_before = 0;
    for (const Gaps gaps : {Gaps::Leave, Gaps::Close}) {
        const Prisms prisms(mesh, 0.2, gaps);
        std::vector<int> around;
        for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
            if (mesh.triangles[t][0] == 0) around.push_back(t);
        ASSERT_EQ(around.size(), 8u);
        const Mesh picture = prism_mesh(mesh, prisms, around);
        const MeshVerdict verdict = check(picture).verdict;
        EXPECT_TRUE(verdict.is_closed() && verdict.is_oriented()) << verdict.summary();
        EXPECT_EQ(verdict.shells, 8);
        EXPECT_GT(verdict.volume_world, volume_before);
        volume_before = verdict.volume_world;
    }
}

TEST(PrismMesh, OfSpikySolidsIsClosedAndWithinItsHalfSpaces) {
    std::mt19937 random(8);
    for (const double half_width : {0.05, 1.0}) {
        const Mesh mesh = random_spiky_solid(50, random);
        const Prisms prisms(mesh, half_width, Gaps::Close);
        for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
            const Mesh picture = prism_mesh(mesh, prisms, std::array{t});
            const MeshVerdict verdict = check(picture).verdict;
            EXPECT_TRUE(verdict.is_closed() && verdict.is_oriented()) << verdict.summary();
            EXPECT_GT(verdict.volume_world, 0);
            EXPECT_FALSE(verdict.reversed);
            const double size = bounding_box(picture).size().maxCoeff();
            // 1e-9 of the size: planes that meet at a hundredth of a degree.
            for (const Vec3d& p : picture.vertices_world)
                for (const HalfSpace& h : prisms.half_spaces(t))
                    EXPECT_LE(h.normal.dot(p), h.offset + 1e-9 * size);
        }
    }
}

} // namespace
} // namespace isocast::test
