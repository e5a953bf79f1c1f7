// The built-in meshes are what the thesis's figure 4.7 needs: closed solids of known size.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/sample_meshes.h"

#include "distance_transform/checked_mesh.h"

#include "cgal_oracle.h"
#include "volume/errors.h"

#include <CGAL/Polygon_mesh_processing/self_intersections.h>

#include <gtest/gtest.h>

#include <numbers>

namespace isocast::test {
namespace {

TEST(SampleMeshes, AreClosedOrientedManifoldSolids) {
    for (const std::string& name : sample_mesh_names()) {
        const CheckedMesh mesh = check(sample_mesh(name));
        EXPECT_EQ(mesh.verdict.summary(), "closed, oriented, manifold") << name;
        EXPECT_TRUE(mesh.warnings.empty()) << name;
        EXPECT_EQ(mesh.verdict.shells, 1) << name;
        EXPECT_GT(mesh.verdict.volume_world, 0) << name;
        EXPECT_FALSE(mesh.verdict.reversed) << name;
    }
}

TEST(SampleMeshes, HaveTheVertexCountsOfTheThesis) {
    EXPECT_EQ(sample_mesh("sphere6").vertices_world.size(), 16386u);
    EXPECT_EQ(sample_mesh("torus").vertices_world.size(), 3000u);
    EXPECT_EQ(sample_mesh("knot").vertices_world.size(), 1440u);
    EXPECT_EQ(sample_mesh("seashell").vertices_world.size(), 915u);
}

TEST(SampleMeshes, DoNotIntersectThemselves) {
    for (const std::string& name : sample_mesh_names())
        EXPECT_FALSE(
            CGAL::Polygon_mesh_processing::does_self_intersect(cgal_mesh(sample_mesh(name))))
            << name;
}

TEST(SampleMeshes, SphereAndTorusHaveNearlyTheVolumesOfTheirModels) {
    const double sphere = 4 * std::numbers::pi / 3;
    const double torus = 2 * std::numbers::pi * std::numbers::pi * 0.4 * 0.4;
    // Inscribed polyhedra: a chord of angle a loses a^2/6 of the volume at most; a is 1/40 on the
    // sphere, 2 pi/50 on the torus.
    const double sphere6 = check(sample_mesh("sphere6")).verdict.volume_world;
    EXPECT_LT(sphere6, sphere);
    EXPECT_GT(sphere6, sphere * 0.999);
    const double torus_mesh = check(sample_mesh("torus")).verdict.volume_world;
    EXPECT_LT(torus_mesh, torus);
    EXPECT_GT(torus_mesh, torus * 0.99);
    for (const Vec3d& p : sample_mesh("sphere6").vertices_world)
        ASSERT_NEAR(p.norm(), 1, 1e-15); // normalised
}

TEST(SampleMeshes, UnknownNameListsTheKnownOnes) {
    try {
        sample_mesh("teapot");
        FAIL();
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "unknown sample mesh 'teapot' (known: sphere6, torus, knot, "
                                   "seashell)");
    }
}

} // namespace
} // namespace isocast::test
