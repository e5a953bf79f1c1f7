// Repaired meshes are closed, oriented and where the given ones were.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/repair/repair.h"

#include "distance_transform/checked_mesh.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

namespace isocast::test {
namespace {

/// The cube [lo, lo + 1]^3; each face two triangles.
Mesh unit_cube(const Vec3d& lo) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices_world.push_back(lo + Vec3d(i & 1, i >> 1 & 1, i >> 2));
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

void append(Mesh& mesh, const Mesh& other) {
    const int first = static_cast<int>(mesh.vertices_world.size());
    mesh.vertices_world.insert(mesh.vertices_world.end(), other.vertices_world.begin(),
                               other.vertices_world.end());
    for (const auto& [a, b, c] : other.triangles)
        mesh.triangles.push_back({first + a, first + b, first + c});
}

double volume(const Mesh& mesh) {
    double six_volumes = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        six_volumes +=
            mesh.vertices_world[a].dot(mesh.vertices_world[b].cross(mesh.vertices_world[c]));
    return six_volumes / 6;
}

void expect_solid(const RepairedMesh& repaired) {
    EXPECT_TRUE(repaired.report.is_closed) << repaired.report.summary();
    const MeshVerdict verdict = check(repaired.mesh).verdict;
    EXPECT_EQ(verdict.boundary_edges, 0);
    EXPECT_EQ(verdict.flipped_edges, 0);
    EXPECT_FALSE(verdict.reversed);
    EXPECT_GT(volume(repaired.mesh), 0);
}

// Dyadic coordinates: volumes of cubes are exact in double, whatever the triangles' order.

TEST(Repair, LeavesASolidAsItIs) {
    const Mesh cube = unit_cube({0, 0, 0});
    const RepairedMesh repaired = repair(cube);
    expect_solid(repaired);
    EXPECT_EQ(repaired.report.summary(), "closed");
    EXPECT_EQ(repaired.mesh.triangles.size(), cube.triangles.size());
    EXPECT_EQ(repaired.mesh.vertices_world, cube.vertices_world);
}

TEST(Repair, FillsTheMissingFaceOfACube) {
    for (std::size_t missing = 0; missing < 12; missing += 2) {
        Mesh open = unit_cube({0, 0, 0});
        const auto first = open.triangles.begin() + static_cast<std::ptrdiff_t>(missing);
        open.triangles.erase(first, first + 2);
        const RepairedMesh repaired = repair(open);
        expect_solid(repaired);
        EXPECT_EQ(repaired.report.summary(), "1 of 1 holes filled with 2 triangles; closed");
        EXPECT_EQ(volume(repaired.mesh), 1);
    }
}

/// Each triangle has vertices of its own, and is turned or not by chance.
TEST(Repair, OrientsASoupOfFlippedTriangles) {
    std::mt19937 random(1);
    const Mesh knot = sample_mesh("knot");
    Mesh soup;
    for (std::array<int, 3> triangle : knot.triangles) {
        if (random() % 2 == 0) std::swap(triangle[1], triangle[2]);
        const int first = static_cast<int>(soup.vertices_world.size());
        for (const int vertex : triangle)
            soup.vertices_world.push_back(knot.vertices_world[vertex]);
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    const RepairedMesh repaired = repair(soup);
    expect_solid(repaired);
    EXPECT_EQ(repaired.mesh.vertices_world.size(), knot.vertices_world.size());
    EXPECT_EQ(repaired.mesh.triangles.size(), knot.triangles.size());
    // 2,880 terms, each below 1 (positions below 4.5, edges near 0.3), summed in another order: as
    // many roundings of sums below 2,880.
    EXPECT_NEAR(volume(repaired.mesh), volume(knot), 2880 * 2880 * 2.2e-16 / 6);
}

TEST(Repair, TurnsASolidThatIsInsideOut) {
    Mesh reversed = unit_cube({0, 0, 0});
    for (auto& triangle : reversed.triangles) std::swap(triangle[1], triangle[2]);
    const RepairedMesh repaired = repair(reversed);
    expect_solid(repaired);
    EXPECT_EQ(volume(repaired.mesh), 1);
}

TEST(Repair, MakesACavityOfAShellInsideAnother) {
    Mesh nested = unit_cube({0, 0, 0});
    for (Vec3d& p : nested.vertices_world) p *= 4;
    append(nested, unit_cube({1, 1, 1}));
    EXPECT_EQ(volume(nested), 64 + 1);
    const RepairedMesh repaired = repair(nested);
    expect_solid(repaired);
    EXPECT_EQ(volume(repaired.mesh), 64 - 1);
}

TEST(Repair, RemovesDuplicateAndDegenerateTriangles) {
    Mesh mesh = unit_cube({0, 0, 0});
    mesh.triangles.push_back(mesh.triangles[0]);
    mesh.triangles.push_back({1, 1, 2});
    const RepairedMesh repaired = repair(mesh);
    expect_solid(repaired);
    EXPECT_EQ(repaired.report.removed_triangles, 2);
    EXPECT_EQ(repaired.mesh.triangles.size(), 12);
}

TEST(Repair, PartsTwoSolidsThatShareAnEdge) {
    Mesh mesh = unit_cube({0, 0, 0});
    append(mesh, unit_cube({1, 1, 0}));
    ASSERT_GT(check(mesh).verdict.non_manifold_edges, 0);
    const RepairedMesh repaired = repair(mesh);
    expect_solid(repaired);
    EXPECT_EQ(repaired.report.holes, 0);
    EXPECT_EQ(repaired.mesh.triangles.size(), 24);
    EXPECT_EQ(volume(repaired.mesh), 2);
}

TEST(Repair, TellsWhenNothingIsLeft) {
    const Mesh line{.vertices_world = {{0, 0, 0}, {1, 0, 0}}, .triangles = {{0, 1, 1}}};
    EXPECT_THROW(repair(line), InputError);
}

TEST(Repair, ClosesTheBunny) {
    const std::filesystem::path path =
        std::filesystem::path(ISOCAST_SHARED_DATA) / "stanford-bunny.obj";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
    const CheckedMesh open = check(read_mesh(path));
    ASSERT_GT(open.verdict.boundary_loops, 0);
    const RepairedMesh repaired = repair(open.mesh);
    expect_solid(repaired);
    EXPECT_EQ(repaired.report.filled_holes, open.verdict.boundary_loops);
    // Filling uses no other vertices, so that none is more than the scan has.
    EXPECT_EQ(repaired.mesh.vertices_world.size(), open.mesh.vertices_world.size());
}

} // namespace
} // namespace isocast::test
