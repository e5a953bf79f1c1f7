// Meshes of isosurfaces: every edge of the lattice that is crossed has its quadrangle, near the
// surface.
// SPDX-License-Identifier: MPL-2.0
#include "volume/isosurface_mesh.h"

#include "volume/analytic_fields.h"
#include "volume/dense_field.h"
#include "volume/placed_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

namespace isocast {
namespace {

double area_of(const IsosurfaceMesh& mesh) {
    double area = 0;
    for (const Eigen::Vector3i& t : mesh.triangles) {
        const auto at = [&](int corner) {
            return mesh.vertices_world[static_cast<std::size_t>(t[corner])];
        };
        area += (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
    }
    return area;
}

TEST(IsosurfaceMesh, OfASphereIsClosedAndOnIt) {
    // 150 samples along an axis: several chunks.
    const auto field = sampled(sphere_field(Vec3d(0.1, 0.2, -0.1), 0.7), 150);
    const double voxel = field->space().voxel_size_world();
    for (const double iso : {0.0, 0.1, -0.2}) {
        const IsosurfaceMesh mesh = isosurface_mesh(*field, iso);
        const double radius = 0.7 + iso;
        // The crossings are within voxel^2 / (8 radius) of the sphere; their mean lies as deep
        // below as a cell is curved: half its diagonal squared over twice the radius.
        const double allowed = voxel * voxel * (0.75 / 2 + 1.0 / 8) / radius;
        for (const Vec3d& v : mesh.vertices_world)
            EXPECT_NEAR((v - Vec3d(0.1, 0.2, -0.1)).norm(), radius, allowed);
        // Two triangles a crossing, and each edge has two of them.
        std::map<std::pair<int, int>, int> edges;
        for (const Eigen::Vector3i& t : mesh.triangles)
            for (int i = 0; i < 3; ++i) ++edges[std::minmax({t[i], t[(i + 1) % 3]})];
        for (const auto& [edge, count] : edges) EXPECT_EQ(count, 2);
        // Euler's number of a sphere.
        EXPECT_EQ(std::ssize(mesh.vertices_world) - std::ssize(edges) + std::ssize(mesh.triangles),
                  2);
        // As a share: depths count twice, and triangles' slopes by a cell's turn, squared.
        EXPECT_NEAR(area_of(mesh) / (4 * std::numbers::pi * radius * radius), 1,
                    2 * voxel / radius);
    }
}

TEST(IsosurfaceMesh, HasTwoTrianglesForEachCrossingOfTheLattice) {
    for (const char* name : {"gyroid", "marschner-lobb", "cube"}) {
        const auto field = sampled(builtin_field(name), 70);
        const IndexBox extent = field->extent();
        std::vector<float> samples(static_cast<std::size_t>(extent.sample_count()));
        field->copy_box(extent, 0, samples);
        std::size_t crossings = 0;
        for (std::size_t i = 0; i < samples.size(); ++i)
            for (const std::size_t stride : {1, 70, 70 * 70})
                crossings += i / stride % 70 < 69 && (samples[i] < 0) != (samples[i + stride] < 0);
        EXPECT_EQ(isosurface_mesh(*field, 0).triangles.size(), 2 * crossings) << name;
    }
}

TEST(IsosurfaceMesh, MovesWithItsField) {
    const std::shared_ptr<const FieldSource> field = sampled(builtin_field("torus"), 40);
    const Placement placement{
        .scale = 2, .rotation_degrees = {10, 20, 30}, .translation_world = {1, 2, 3}};
    const IsosurfaceMesh mesh = isosurface_mesh(*field, 0.1);
    const IsosurfaceMesh placed = isosurface_mesh(PlacedField(field, placement), 0.2);
    ASSERT_EQ(placed.vertices_world.size(), mesh.vertices_world.size());
    for (std::size_t i = 0; i < mesh.vertices_world.size(); ++i)
        EXPECT_LT((placed.vertices_world[i] - placement.to_world() * mesh.vertices_world[i]).norm(),
                  1e-6); // roundings of samples, twice as large
}

TEST(IsosurfaceMesh, IsEmptyWhereThereIsNoSurface) {
    const auto field = sampled(builtin_field("sphere"), 20);
    EXPECT_TRUE(isosurface_mesh(*field, 100).triangles.empty());
    EXPECT_TRUE(isosurface_mesh(*field, -100).vertices_world.empty());
}

} // namespace
} // namespace isocast
