// The closest point of a triangle, slivers and degenerate ones included.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/point_triangle.h"

#include "distance_transform/brute_force.h"

#include <gtest/gtest.h>

#include <random>

namespace isocast::test {
namespace {

using Corners = std::array<Vec3d, 3>;

class Random {
public:
    explicit Random(unsigned seed) : engine_(seed) {}
    Vec3d vector(double size = 1) {
        return size * Vec3d(uniform_(engine_), uniform_(engine_), uniform_(engine_));
    }
    double exponent(double lo, double hi) {
        return std::pow(10, lo + (hi - lo) * (uniform_(engine_) + 1) / 2);
    }

private:
    std::mt19937 engine_;
    std::uniform_real_distribution<double> uniform_{-1, 1};
};

/// The closest point q of a convex set to p is the one for which no corner v lies beyond the plane
/// through q across p - q: (p - q) · (v - q) <= 0. Returns by how much that fails, over the size
/// of the factors.
double violation(const Vec3d& p, const Corners& corners, const Vec3d& q) {
    double worst = 0;
    double size = 0;
    for (const Vec3d& v : corners) {
        worst = std::max(worst, (p - q).dot(v - q));
        size = std::max({size, (v - q).norm(), (p - q).norm()});
    }
    return size > 0 ? worst / (size * size) : 0;
}

/// Distance of `q` from the segment that its feature says, or from the plane.
double distance_from_feature(const ClosestPoint& found, const Corners& corners) {
    const auto from_line = [&](int a, int b) {
        const Vec3d u = (corners[b] - corners[a]).normalized();
        return u.cross(found.p - corners[a]).norm();
    };
    switch (found.feature) {
    case Feature::Edge01:
        return from_line(0, 1);
    case Feature::Edge12:
        return from_line(1, 2);
    case Feature::Edge20:
        return from_line(2, 0);
    case Feature::Vertex0:
        return (found.p - corners[0]).norm();
    case Feature::Vertex1:
        return (found.p - corners[1]).norm();
    case Feature::Vertex2:
        return (found.p - corners[2]).norm();
    case Feature::Face:
        break;
    }
    const Vec3d n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    return std::abs(n.dot(found.p - corners[0]));
}

TEST(PointTriangle, SatisfiesTheConditionOfTheClosestPoint) {
    Random random(1);
    std::array<int, 7> seen{};
    for (int i = 0; i < 200000; ++i) {
        const Corners corners = {random.vector(), random.vector(), random.vector()};
        const Vec3d p = random.vector(2);
        const ClosestPoint found = closest_point(p, corners);
        ++seen[static_cast<std::size_t>(found.feature)];
        // Some ten roundings of 1e-16, over triangles down to a height of 1e-4 of their length.
        ASSERT_LT(violation(p, corners, found.p), 1e-12);
        ASSERT_LT(distance_from_feature(found, corners), 1e-12);
        ASSERT_NEAR(found.squared_distance, (p - found.p).squaredNorm(), 1e-13);
    }
    for (const int count : seen) EXPECT_GT(count, 2000); // all seven features were there
}

TEST(PointTriangle, AgreesWithTheIndependentOracle) {
    Random random(2);
    for (int i = 0; i < 100000; ++i) {
        const Mesh mesh{{random.vector(), random.vector(), random.vector()}, {{0, 1, 2}}};
        const Vec3d p = random.vector(2);
        const double found =
            std::sqrt(closest_point(p, {mesh.vertices_world[0], mesh.vertices_world[1],
                                        mesh.vertices_world[2]})
                          .squared_distance);
        ASSERT_NEAR(found, brute_force_distance(mesh, p), 1e-11); // the oracle's own roundings
    }
}

TEST(PointTriangle, SliversKeepTheirDistance) {
    Random random(3);
    for (int i = 0; i < 200000; ++i) {
        // A needle or a cap whose height is 1e-2 to 1e-16 of its length, points near and far.
        const Vec3d a = random.vector();
        const Vec3d along = random.vector();
        const double height = random.exponent(-16, -2);
        const double at = i % 3 == 0 ? 0.5 : i % 3 == 1 ? random.exponent(-9, 0) : 1.0;
        const Corners corners = {a, a + along, a + at * along + random.vector(height)};
        const Vec3d p = a + 0.5 * along + random.vector(random.exponent(-12, 1));
        const ClosestPoint found = closest_point(p, corners);
        // q is within 1e-10 lengths of the closest point (sliver_ratio), which shifts both factors
        // of the condition.
        ASSERT_LT(violation(p, corners, found.p), 1e-9);
    }
}

TEST(PointTriangle, DegenerateTrianglesCountAsTheirEdges) {
    Random random(4);
    for (int i = 0; i < 20000; ++i) {
        const Vec3d a = random.vector();
        const Vec3d b = i % 4 == 0 ? a : random.vector();
        const Vec3d c = i % 2 == 0 ? b : Vec3d(a + 0.25 * (b - a));
        const Vec3d p = random.vector(2);
        const ClosestPoint found = closest_point(p, {a, b, c});
        ASSERT_TRUE(found.p.allFinite());
        const double length = (b - a).squaredNorm();
        const double t = length > 0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0;
        ASSERT_NEAR(std::sqrt(found.squared_distance), (p - (a + t * (b - a))).norm(), 1e-14);
    }
}

TEST(PointTriangle, PointsOnTheTriangleHaveDistanceZero) {
    const Corners corners = {Vec3d(0, 0, 0), Vec3d(4, 0, 0), Vec3d(0, 4, 0)};
    const auto expect_on = [&](const Vec3d& p, Feature feature) {
        const ClosestPoint found = closest_point(p, corners);
        EXPECT_EQ(found.squared_distance, 0);
        EXPECT_EQ(found.p, p);
        EXPECT_EQ(found.feature, feature);
    };
    expect_on({0, 0, 0}, Feature::Vertex0);
    expect_on({4, 0, 0}, Feature::Vertex1);
    expect_on({0, 4, 0}, Feature::Vertex2);
    expect_on({1, 0, 0}, Feature::Edge01);
    expect_on({2, 2, 0}, Feature::Edge12);
    expect_on({0, 3, 0}, Feature::Edge20);
    expect_on({1, 1, 0}, Feature::Face);
}

} // namespace
} // namespace isocast::test
