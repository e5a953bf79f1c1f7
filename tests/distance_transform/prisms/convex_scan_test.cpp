// Scan conversion against a test of every sample by every half-space.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convex_scan.h"

#include "meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bitset>
#include <limits>

namespace isocast::test {
namespace {

/// Greatest normal · p - offset: how far p is outside.
double excess(const std::vector<HalfSpace>& polyhedron, const Vec3d& p) {
    double greatest = -std::numeric_limits<double>::infinity();
    for (const HalfSpace& h : polyhedron) greatest = std::max(greatest, h.normal.dot(p) - h.offset);
    return greatest;
}

std::bitset<samples_per_block> scanned(const std::vector<HalfSpace>& polyhedron,
                                       const Index3& block) {
    std::bitset<samples_per_block> inside;
    scan_block(polyhedron, block, [&](const Index3& p, int i) {
        EXPECT_FALSE(inside[i]);
        EXPECT_EQ(p, block_size * block + Index3(i % 8, i / 8 % 8, i / 64));
        inside[i] = true;
    });
    return inside;
}

/// Half-spaces about a point near the origin's block; some normals along axes and diagonals.
std::vector<HalfSpace> random_polyhedron(std::mt19937& random) {
    std::uniform_real_distribution<double> offset(-1, 5);
    std::uniform_real_distribution<double> coordinate(-4, 12);
    const Vec3d middle(coordinate(random), coordinate(random), coordinate(random));
    std::vector<HalfSpace> polyhedron;
    const int count = std::uniform_int_distribution(1, 8)(random);
    for (int i = 0; i < count; ++i) {
        Vec3d normal = random_unit(random);
        if (random() % 3 == 0) normal = normal.array().round().matrix();
        if (normal.isZero()) normal = Vec3d::UnitY();
        normal.normalize();
        polyhedron.push_back({normal, normal.dot(middle) + offset(random)});
    }
    return polyhedron;
}

TEST(ConvexScan, FindsTheSamplesInsideAllHalfSpaces) {
    std::mt19937 random(1);
    int inside_count = 0;
    for (int round = 0; round < 500; ++round) {
        const std::vector<HalfSpace> polyhedron = random_polyhedron(random);
        const Index3 block(static_cast<int>(random() % 3) - 1, static_cast<int>(random() % 3) - 1,
                           static_cast<int>(random() % 3) - 1);
        const auto inside = scanned(polyhedron, block);
        inside_count += static_cast<int>(inside.count());
        for (int i = 0; i < samples_per_block; ++i) {
            const Index3 p = block_size * block + Index3(i % 8, i / 8 % 8, i / 64);
            const double beyond = excess(polyhedron, p.cast<double>()) - scan_slack;
            // 1e-12: rounding of sums of three products below 100; there either answer will do.
            if (std::abs(beyond) > 1e-12) {
                ASSERT_EQ(inside[i], beyond < 0) << p.transpose();
            }
        }
    }
    EXPECT_GT(inside_count, 10000);
}

TEST(ConvexScan, HalfSpacesAreClosed) {
    // The cube [2, 5]^3, with its faces on samples.
    std::vector<HalfSpace> cube_faces;
    for (int k = 0; k < 3; ++k) {
        cube_faces.push_back({Vec3d::Unit(k), 5});
        cube_faces.push_back({-Vec3d::Unit(k), -2});
    }
    EXPECT_EQ(scanned(cube_faces, Index3::Zero()).count(), 4u * 4 * 4);
    EXPECT_EQ(scanned(cube_faces, Index3(1, 0, 0)).count(), 0u);
}

TEST(ConvexScan, PolyhedraThatTouchLeaveNoSampleBetween) {
    std::mt19937 random(2);
    for (int round = 0; round < 500; ++round) {
        const Index3 block(static_cast<int>(random() % 1000), static_cast<int>(random() % 1000),
                           static_cast<int>(random() % 1000));
        // A plane through a sample.
        const Vec3d on_plane =
            (block_size * block).cast<double>() + Vec3d(random() % 8, random() % 8, random() % 8);
        Vec3d normal = random_unit(random);
        if (round % 2 == 0) normal = Vec3d(1, 1, round % 4 == 0 ? 0 : 1).normalized();
        // Each side takes its offset from another point of the plane, and rounds it differently.
        const Vec3d elsewhere = on_plane + 50 * normal.unitOrthogonal();
        const HalfSpace below{normal, normal.dot(on_plane)};
        const HalfSpace above{-normal, -normal.dot(elsewhere)};
        EXPECT_TRUE((scanned({below}, block) | scanned({above}, block)).all());
    }
}

TEST(ConvexScan, ListsEveryBlockThatHoldsASampleAndEachOnce) {
    std::mt19937 random(3);
    for (int round = 0; round < 200; ++round) {
        const std::vector<HalfSpace> polyhedron = random_polyhedron(random);
        const WorldBox box{Vec3d(-11.5, -8, -0.5), Vec3d(9, 20.25, 15)};
        const std::vector<Index3> listed = blocks_meeting(polyhedron, box);
        EXPECT_TRUE(std::ranges::is_sorted(listed, zyx_less));
        EXPECT_EQ(std::ranges::adjacent_find(listed), listed.end());
        for (int z = -1; z <= 1; ++z)
            for (int y = -1; y <= 2; ++y)
                for (int x = -2; x <= 1; ++x)
                    if (scanned(polyhedron, Index3(x, y, z)).any()) {
                        ASSERT_NE(std::ranges::find(listed, Index3(x, y, z)), listed.end());
                    }
    }
}

} // namespace
} // namespace isocast::test
