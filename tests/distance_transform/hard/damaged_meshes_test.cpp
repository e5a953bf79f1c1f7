// Slivers, empty, repeated, turned and missing triangles, seams that do not match.
// SPDX-License-Identifier: MPL-2.0
#include "exact_field.h"

namespace isocast::test {
namespace {

TEST(HardMeshes, SliversAreExact) {
    for (const double height : {1e-5, 1e-9, 1e-13}) {
        SCOPED_TRACE(height);
        expect_exact_conversion(with_slivers(noisy_sphere(1, 2), height), 0.11);
    }
}

// Halves of dyadic edges are exact, so the triangle that closes the seam has no area at all.
TEST(HardMeshes, TrianglesWithoutAreaAreExact) {
    Mesh mesh = with_seams(rounded(noisy_sphere(2, 2)), 0.5, true);
    const auto [a, b, c] = mesh.triangles[1];
    mesh.triangles.insert(mesh.triangles.end(), {{a, a, b}, {c, c, c}});
    ASSERT_EQ(check(mesh).verdict.degenerate_triangles, 43 + 2);
    expect_exact_conversion(mesh, 0.11);
}

// A third of an edge is rounded: the triangle has an area of rounding errors, and any normal.
TEST(HardMeshes, TrianglesWithAnAreaOfRoundingErrorsAreExact) {
    expect_exact_conversion(with_seams(tilted(noisy_sphere(3, 2)), 1.0 / 3, true), 0.11);
}

TEST(HardMeshes, TJunctionsAreExact) {
    expect_exact_conversion(with_seams(rounded(noisy_sphere(4, 2)), 0.5, false), 0.11);
}

// The seams gape by rounding errors.
TEST(HardMeshes, RoundedTJunctionsAreExact) {
    expect_exact_conversion(with_seams(tilted(noisy_sphere(5, 2)), 1.0 / 3, false), 0.11);
}

TEST(HardMeshes, RepeatedTrianglesCountOnce) {
    const Mesh solid = noisy_sphere(6, 3);
    Mesh mesh = solid;
    for (std::size_t t = 0; t < solid.triangles.size(); t += 2) {
        const auto& [a, b, c] = solid.triangles[t];
        mesh.triangles.push_back({b, c, a});
    }
    ASSERT_EQ(check(mesh).verdict.duplicate_triangles, 256);
    expect_exact_conversion(mesh, 0.11, solid);
}

// Each triangle has vertices of its own, some repeat another one turned round.
TEST(HardMeshes, UnindexedSoupIsExact) {
    const Mesh solid = noisy_sphere(7, 3);
    Mesh mesh;
    for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
        const int first = static_cast<int>(mesh.vertices_world.size());
        for (const int vertex : solid.triangles[t])
            mesh.vertices_world.push_back(solid.vertices_world[vertex]);
        mesh.triangles.push_back({first, first + 1, first + 2});
        if (t % 10 == 0) mesh.triangles.push_back({first, first + 2, first + 1});
    }
    expect_exact_conversion(mesh, 0.11, solid);
}

// The mesh is closed, so there is one orientation that all triangles can agree on.
TEST(HardMeshes, OneFlippedTriangleDoesNotChangeTheSigns) {
    const Mesh solid = noisy_sphere(8, 3);
    Mesh mesh = solid;
    std::swap(mesh.triangles[100][1], mesh.triangles[100][2]);
    ASSERT_EQ(check(mesh).verdict.flipped_edges, 3);
    expect_exact_conversion(mesh, 0.11, solid);
}

TEST(HardMeshes, ATenthOfTheTrianglesFlippedDoesNotChangeTheSigns) {
    const Mesh solid = noisy_sphere(9, 3);
    Mesh mesh = solid;
    std::mt19937 random(9);
    for (Triangle& triangle : mesh.triangles)
        if (random() % 10 == 0) std::swap(triangle[1], triangle[2]);
    expect_exact_conversion(mesh, 0.11, solid);
}

// A cap of 8 % of the triangles is missing.
TEST(HardMeshes, HoleOfATwelfthHasExactDistancesAndTheWindingNumbersSigns) {
    Mesh mesh = noisy_sphere(10, 3);
    const std::size_t whole = mesh.triangles.size();
    std::ranges::sort(mesh.triangles, {}, [&](const Triangle& triangle) {
        return mesh.vertices_world[triangle[0]].z() + mesh.vertices_world[triangle[1]].z() +
               mesh.vertices_world[triangle[2]].z();
    });
    mesh.triangles.resize(whole - whole * 8 / 100);
    const ConvertResult result = expect_exact_conversion(mesh, 0.15, mesh, Sides::Open);
    EXPECT_EQ(result.sign_used, SignMethod::Winding);
}

/// The cube of an n x n grid a face, so that most neighbours are coplanar.
Mesh gridded_cube(int times) {
    return subdivided(cube(), times);
}

double distance_to_cube(const Vec3d& p, double half) {
    const Vec3d q = p.cwiseAbs() - Vec3d::Constant(half);
    return std::abs(q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0));
}

// Faces on samples, edges on samples, vertices on samples; the band ends on samples too, and 3
// voxels is as far as 3 voxels.
TEST(HardMeshes, VerticesOnSamplesAndCoplanarNeighboursAreExact) {
    for (const int times : {0, 3})
        for (const double half_width : {3.0, 8.0}) {
            SCOPED_TRACE(half_width);
            const Mesh mesh = gridded_cube(times);
            const SparseField field =
                convert(check(mesh), {.voxel_size_world = 0x1p-3, .half_width_voxels = half_width})
                    .field;
            const IndexBox box = box_about(mesh, field.space(), half_width);
            const Vec3d middle = -box.lo.cast<double>();
            const KnownField known = known_field(
                {.distance_near =
                     [&](const Vec3d&, double) {
                         return [&](const Vec3d& p) { return distance_to_cube(p - middle, 8); };
                     },
                 .winding =
                     [&](const Vec3d& p) {
                         return (p - middle).cwiseAbs().maxCoeff() < 8 ? 1.0 : 0.0;
                     }},
                box, half_width);
            // All is exact: no rounding.
            expect_no_faults(faults_of(field, known, half_width, false, 0));
        }
}

TEST(HardMeshes, TiltedCubeOfCoplanarNeighboursIsExact) {
    expect_exact_conversion(tilted(gridded_cube(2)), 0.11);
}

TEST(HardMeshes, RandomVerticesOnSamplesAreExact) {
    for (unsigned seed = 0; seed < 4; ++seed) {
        Mesh mesh = mapped(noisy_sphere(20 + seed, 2),
                           [](const Vec3d& p) { return Vec3d((8 * p).array().round()); });
        SCOPED_TRACE(seed);
        expect_exact_conversion(mesh, 1);
    }
}

} // namespace
} // namespace isocast::test
