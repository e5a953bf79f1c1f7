// Scattered points lie on the mesh, evenly, and no two of them close together.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/scatter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>

namespace isocast {
namespace {

using std::numbers::pi;

struct TestMesh {
    std::vector<Vec3d> vertices;
    std::vector<Eigen::Vector3i> triangles;

    double area(std::size_t t) const {
        const auto& [a, b, c] = std::array{vertices[std::size_t(triangles[t][0])],
                                           vertices[std::size_t(triangles[t][1])],
                                           vertices[std::size_t(triangles[t][2])]};
        return (b - a).cross(c - a).norm() / 2;
    }
    double area() const {
        double sum = 0;
        for (std::size_t t = 0; t < triangles.size(); ++t) sum += area(t);
        return sum;
    }
    std::vector<SurfacePoint> scattered(std::size_t count, std::uint64_t seed) const {
        return scatter(vertices, triangles, count, seed);
    }
};

/// n by m quads; larger triangles outside than inside.
TestMesh torus(int n, int m, double minor = 0.4) {
    TestMesh mesh;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            const double u = 2 * pi * i / n, v = 2 * pi * j / m;
            const double r = 1 + minor * std::cos(v);
            mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), minor * std::sin(v));
            const int a = i * m + j, b = (i + 1) % n * m + j;
            const int c = (i + 1) % n * m + (j + 1) % m, d = i * m + (j + 1) % m;
            mesh.triangles.emplace_back(a, b, c);
            mesh.triangles.emplace_back(a, c, d);
        }
    return mesh;
}

/// The unit square as two triangles.
TestMesh square() {
    return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
}

double closest_pair(std::span<const SurfacePoint> points) {
    double closest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            closest =
                std::min(closest, (points[i].position_world - points[j].position_world).norm());
    return closest;
}

TEST(Scatter, PointsAreAsManyAsAskedForAndLieOnTheirTriangles) {
    const TestMesh mesh = torus(24, 12);
    for (const std::size_t count : {0UL, 1UL, 2UL, 7UL, 1000UL}) {
        const std::vector<SurfacePoint> points = mesh.scattered(count, 3);
        ASSERT_EQ(points.size(), count);
        int before = 0;
        for (const SurfacePoint& p : points) {
            EXPECT_GE(p.triangle, before);
            before = p.triangle;
            EXPECT_GE(p.barycentric.minCoeff(), 0);
            // Three roundings of numbers up to 1.
            EXPECT_LE(std::abs(p.barycentric.sum() - 1), 4e-16);
            Vec3d position = Vec3d::Zero();
            for (int c = 0; c < 3; ++c)
                position += p.barycentric[c] *
                            mesh.vertices[std::size_t(mesh.triangles[std::size_t(p.triangle)][c])];
            EXPECT_EQ(position, p.position_world);
        }
    }
}

TEST(Scatter, ASeedGivesTheSamePointsAndAnotherGivesOthers) {
    const TestMesh mesh = torus(12, 8);
    const auto once = mesh.scattered(200, 1), again = mesh.scattered(200, 1);
    const auto other = mesh.scattered(200, 2);
    ASSERT_EQ(once.size(), again.size());
    for (std::size_t i = 0; i < once.size(); ++i) {
        EXPECT_EQ(once[i].position_world, again[i].position_world);
        EXPECT_NE(once[i].position_world, other[i].position_world);
    }
}

TEST(Scatter, PointsKeepTheirDistance) {
    for (const TestMesh& mesh : {torus(48, 24), square()})
        for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
            const std::size_t count = 2000;
            const double greatest =
                2 * std::sqrt(mesh.area() / (2 * std::numbers::sqrt3 * double(count)));
            const double share = closest_pair(mesh.scattered(count, seed)) / greatest;
            std::printf("relative radius %.3f\n", share);
            EXPECT_GE(share, 0.65); // what scatter.h states
            EXPECT_LE(share, 1);    // no set does better on a plane
            // The closest of n random pairs at density n / area: the n^2 / 2 pairs are within r
            // with chance pi r^2 / area each, so that one is expected at r = sqrt(2 area / pi) / n;
            // a tenth of ours is far more than that.
            EXPECT_GT(share * greatest, 10 * std::sqrt(2 * mesh.area() / pi) / double(count));
        }
}

/// The distances that random points keep, with the same mesh and count, for comparison.
TEST(Scatter, RandomPointsWouldNotKeepTheirDistance) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<SurfacePoint> points(2000);
    for (SurfacePoint& p : points) p.position_world = {share(random), share(random), 0};
    EXPECT_GT(closest_pair(square().scattered(2000, 1)), 10 * closest_pair(points));
}

// Counts in parts of a closed mesh, over many seeds, against each part's share of the area.
TEST(Scatter, NoPlaceOfAClosedMeshIsFavoured) {
    const TestMesh mesh = torus(32, 16);
    // By the way around the tube: inner parts are small and bend the other way.
    constexpr std::size_t part_count = 16;
    const auto part_of = [](int triangle) { return std::size_t(triangle) / 2 % part_count; };
    std::array<double, part_count> expected{}, counted{};
    constexpr std::size_t count = 500;
    constexpr int seeds = 40;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        expected[part_of(int(t))] += mesh.area(t) / mesh.area() * double(count) * seeds;
    for (int seed = 0; seed < seeds; ++seed)
        for (const SurfacePoint& p : mesh.scattered(count, std::uint64_t(seed)))
            ++counted[part_of(p.triangle)];
    double chi_square = 0;
    for (std::size_t k = 0; k < part_count; ++k)
        chi_square += (counted[k] - expected[k]) * (counted[k] - expected[k]) / expected[k];
    std::printf("chi square %.2f of 15 degrees of freedom\n", chi_square);
    // 37.70: the 99.9 % quantile with 15 degrees of freedom, of independent points; these vary
    // less.
    EXPECT_LE(chi_square, 37.70);
}

TEST(Scatter, BordersOfOpenMeshesAreDenser) {
    constexpr std::size_t count = 1000;
    constexpr int seeds = 20;
    // The strip as wide as half the spacing along all four sides.
    const double strip = std::sqrt(1 / (2 * std::numbers::sqrt3 * double(count)));
    double in_strip = 0;
    for (int seed = 0; seed < seeds; ++seed)
        for (const SurfacePoint& p : square().scattered(count, std::uint64_t(seed))) {
            const Vec3d& x = p.position_world;
            in_strip += std::min({x.x(), x.y(), 1 - x.x(), 1 - x.y()}) < strip;
        }
    const double expected = (1 - (1 - 2 * strip) * (1 - 2 * strip)) * count * seeds;
    std::printf("in the strip along the border: %.2f times its share\n", in_strip / expected);
    EXPECT_GT(in_strip, expected);
    EXPECT_LT(in_strip, 1.7 * expected);
}

TEST(Scatter, TrianglesWithoutAnAreaGetNone) {
    TestMesh mesh = torus(12, 8);
    const std::size_t whole = mesh.triangles.size();
    // Between the others, at the front, and at the end: two corners in one place, three on a line.
    std::vector<Eigen::Vector3i> triangles = {{0, 0, 1}, {5, 5, 5}};
    for (const Eigen::Vector3i& t : mesh.triangles) {
        triangles.push_back(t);
        triangles.emplace_back(t[0], t[1], t[0]);
    }
    const int far = int(mesh.vertices.size());
    for (const double x : {0.0, 1.0, 100.0}) mesh.vertices.emplace_back(x, 0, 0);
    triangles.emplace_back(far, far + 1, far + 2);
    mesh.triangles = triangles;
    const auto points = mesh.scattered(300, 1);
    EXPECT_EQ(points.size(), 300U);
    for (const SurfacePoint& p : points) EXPECT_GT(mesh.area(std::size_t(p.triangle)), 0);
    EXPECT_EQ(triangles.size(), 2 * whole + 3);

    EXPECT_TRUE(scatter(mesh.vertices, std::span(triangles).first(2), 10, 1).empty());
    EXPECT_TRUE(scatter({}, {}, 10, 1).empty());
}

// The cells of the search must not depend on where and how large the mesh is.
TEST(Scatter, ScalesWithTheMesh) {
    const TestMesh mesh = torus(12, 8);
    for (const double scale : {0x1p-60, 0x1p60}) {
        TestMesh scaled = mesh;
        for (Vec3d& v : scaled.vertices) v *= scale;
        const auto expected = mesh.scattered(300, 1), points = scaled.scattered(300, 1);
        ASSERT_EQ(points.size(), expected.size());
        for (std::size_t i = 0; i < points.size(); ++i) // powers of two round nothing
            EXPECT_EQ(points[i].position_world, scale * expected[i].position_world);
    }
}

// A ribbon 1e9 times as long as it is wide has few cells across and more along than fit a key.
TEST(Scatter, NeedlesAreCovered) {
    const TestMesh needle{{{0, 0, 0}, {1e9, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    const auto points = needle.scattered(100, 1);
    ASSERT_EQ(points.size(), 100U);
    const auto beyond_half = std::count_if(
        points.begin(), points.end(), [](const auto& p) { return p.position_world.x() > 0.5e9; });
    EXPECT_NEAR(double(beyond_half), 25, 5); // 4.3: the standard deviation of independent ones
}

} // namespace
} // namespace isocast
