// Normals at corners: smooth within creases, flat across them.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/corner_normals.h"

#include "distance_transform/checked_mesh.h"
#include "distance_transform/sample_meshes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isocast::test {
namespace {

std::vector<Eigen::Vector3f> normals_of(const Mesh& mesh, double crease_degrees) {
    return corner_normals(mesh, topology_of(mesh), crease_degrees);
}

Vec3d corner_of(const Mesh& mesh, std::size_t corner) {
    return mesh.vertices_world[static_cast<std::size_t>(mesh.triangles[corner / 3][corner % 3])];
}

TEST(CornerNormals, OfASphereAreRadialAndThoseOfFacesWhereEverythingIsACrease) {
    const Mesh sphere = subdivided_sphere(3);
    const auto smooth = normals_of(sphere, 30);
    const auto flat = normals_of(sphere, 0);
    ASSERT_EQ(smooth.size(), 3 * sphere.triangles.size());
    double tilt = 0;  // of faces, against the sphere at their corners
    double worst = 0; // of smooth normals
    for (std::size_t i = 0; i < smooth.size(); ++i) {
        const Vec3d face = face_normal(sphere, static_cast<int>(i / 3));
        tilt = std::max(tilt, (face - corner_of(sphere, i)).norm());
        worst = std::max(worst, (smooth[i].cast<double>() - corner_of(sphere, i)).norm());
        EXPECT_LT((flat[i].cast<double>() - face).norm(), 1e-6);
    }
    // The tilts around a vertex cancel but for its triangles' differences in size, a third at most.
    EXPECT_LT(worst, tilt / 3);
}

TEST(CornerNormals, AreSharedAcrossEdgesThatBendByLessThanTheCreaseAlone) {
    // A roof that bends by 60 degrees along the y axis, of two rectangles.
    const double c = std::cos(std::acos(-1.0) / 6);
    const Mesh roof{
        .vertices_world =
            {{0, 0, 0}, {0, 1, 0}, {c, 0, -0.5}, {c, 1, -0.5}, {-c, 0, -0.5}, {-c, 1, -0.5}},
        .triangles = {{0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4}}};
    const Vec3d right(0.5, 0, c);
    const Vec3d left(-0.5, 0, c);
    for (const double crease : {59.0, 61.0}) {
        const auto normals = normals_of(roof, crease);
        for (std::size_t i = 0; i < normals.size(); ++i) {
            const bool is_on_ridge = corner_of(roof, i).x() == 0;
            const Vec3d face = i < 6 ? right : left;
            const Vec3d expected = crease > 60 && is_on_ridge ? Vec3d::UnitZ() : face;
            // Right angles on both sides weigh the same, however they are cut into triangles.
            EXPECT_LT((normals[i].cast<double>() - expected).norm(), 1e-6) << crease << ": " << i;
        }
    }
}

TEST(CornerNormals, DoNotMixSidesThatAreTurnedAgainstEachOther) {
    const Mesh turned{.vertices_world = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0}},
                      .triangles = {{0, 2, 1}, {0, 3, 1}}}; // the second one faces away
    for (const Eigen::Vector3f& normal : normals_of(turned, 180))
        EXPECT_EQ(std::abs(normal.z()), 1);
}

} // namespace
} // namespace isocast::test
