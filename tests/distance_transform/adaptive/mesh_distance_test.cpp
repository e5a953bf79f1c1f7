// The distance to a mesh by its tree, against all triangles one by one.
// SPDX-License-Identifier: MPL-2.0
#include "adaptive_fields.h"

#include "distance_transform/leaf_judge.h"
#include "distance_transform/point_triangle.h"

#include <gtest/gtest.h>

namespace isocast::test {

namespace {

/// Triangles in [-size, size]^3 about `middle`, the third corners at most `height` from an edge,
/// and each once more, as far from it as floats can hardly tell.
Mesh soup(const Vec3d& middle, double size, double height, int count, Random& random) {
    Mesh mesh;
    for (int i = 0; i < count; ++i) {
        const Vec3d a = middle + random_point(random, -size, size);
        const Vec3d b = a + random_point(random, -size / 4, size / 4);
        const Vec3d c =
            a + random_real(random, 0, 1) * (b - a) + random_point(random, -height, height);
        const double least = size * 0x1p-23;
        for (const Vec3d& by : {Vec3d(Vec3d::Zero()), random_point(random, -least, least)}) {
            const auto first = static_cast<int>(mesh.vertices_world.size());
            mesh.vertices_world.insert(mesh.vertices_world.end(), {a + by, b + by, c + by});
            mesh.triangles.push_back({first, first + 1, first + 2});
        }
    }
    return mesh;
}

double nearest_of_all(const Mesh& mesh, const Vec3d& p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : mesh.triangles) {
        // As seen from p: far from the origin closest_point loses digits.
        const std::array<Vec3d, 3> corners = {
            mesh.vertices_world[a] - p, mesh.vertices_world[b] - p, mesh.vertices_world[c] - p};
        nearest = std::min(nearest, closest_point(Vec3d::Zero(), corners).p.norm());
    }
    return nearest;
}

} // namespace

TEST(MeshDistance, IsThatOfTheNearestOfAllTriangles) {
    Random random(71);
    constexpr double size = 16;
    // Round triangles, needles, slivers whose frames are just trusted, and just not.
    for (const double height : {4.0, 0.01, 3e-5, 1e-6, 0.0})
        for (const double away : {0.0, 1e3, 5e5}) {
            const Vec3d middle(away, -away / 2, away / 3);
            const MeshInCells input(soup(middle, size, height, 400, random));
            ExactDistance::Hint hint = 0;
            for (int i = 0; i < 2000; ++i) {
                const double reach = i % 4 == 0 ? 8 * size : size;
                Vec3d p = middle + random_point(random, -reach, reach);
                if (i % 5 == 0) // close to a triangle, where the bounds are as small as rounding
                    p = input.mesh().vertices_world[static_cast<std::size_t>(i / 5)] +
                        1e-4 * (p - middle);
                const double expected = nearest_of_all(input.mesh(), p);
                // By how much a trusted frame's axes may turn (2^-53 over sliver_ratio), over the
                // way from a triangle's corner to p, and 30 roundings of coordinates.
                const double tolerance = 1.2e-10 * (expected + size) + 30 * 0x1p-53 * (away + size);
                EXPECT_NEAR(std::abs(input.distance().at(p, hint).distance), expected, tolerance)
                    << "height " << height << ", " << away << " away, at " << p.transpose();
            }
        }
}

TEST(DistanceBounds, HoldTheDistanceToAMesh) {
    Random random(72);
    constexpr double size = 16;
    const MeshInCells input(soup(Vec3d::Zero(), size, 4, 100, random));
    ExactDistance::Hint hint = 0;
    const auto distance_at = [&](const Vec3d& p) { return input.distance().at(p, hint).distance; };
    double narrowest = 1;
    for (int i = 0; i < 5000; ++i) {
        const Cube cube{random_point(random, -3 * size, 3 * size),
                        size * std::exp2(random_real(random, -8, 1))};
        std::array<NodeData, 8> corners{};
        for (int k = 0; k < 8; ++k)
            corners[static_cast<std::size_t>(k)][0] =
                static_cast<float>(distance_at(cube.centre + cube.half_edge * corner_direction(k)));
        const Vec3d from_centre =
            i % 3 == 0 ? Vec3d(Vec3d::Unit(i % 9 / 3)) : random_point(random, -1, 1);
        const double distance = std::abs(distance_at(cube.centre + cube.half_edge * from_centre));
        const DistanceBounds bounds =
            distance_bounds(cube, corners, distance_at(cube.centre), from_centre);
        // Less what double coordinates of up to 4 sizes round.
        EXPECT_LE(bounds.least, distance + 1e-14 * size);
        EXPECT_GE(bounds.greatest, distance - 1e-14 * size);
        narrowest = std::min(narrowest, (bounds.greatest - bounds.least) / cube.half_edge);
    }
    EXPECT_LT(narrowest, 0.5); // they say something
}

} // namespace isocast::test
