// Queries of all kD-tree variants against brute force.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/brute_force.h"
#include "distance_transform/kd_tree.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

namespace isocast::test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::array variants = {KdVariant::Overlapping, KdVariant::ObjectsAtNodes,
                                 KdVariant::SplitReferences};

class Random {
public:
    explicit Random(unsigned seed) : engine_(seed) {}
    double number() { return distribution_(engine_); } // in [-1, 1]
    Vec3d point() {
        const double x = number();
        const double y = number();
        return {x, y, number()};
    }

private:
    std::mt19937_64 engine_;
    std::uniform_real_distribution<double> distribution_{-1, 1};
};

std::array<Vec3d, 3> corners_of(const Mesh& mesh, std::size_t t) {
    const auto [a, b, c] = mesh.triangles[t];
    return {mesh.vertices_world[a], mesh.vertices_world[b], mesh.vertices_world[c]};
}

void add_triangle(Mesh& mesh, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const int first = static_cast<int>(mesh.vertices_world.size());
    mesh.vertices_world.insert(mesh.vertices_world.end(), {a, b, c});
    mesh.triangles.push_back({first, first + 1, first + 2});
}

/// Triangles of all sizes about random places in the cube of edge 2.
Mesh random_soup(unsigned seed, int count) {
    Random random(seed);
    Mesh mesh;
    for (int i = 0; i < count; ++i) {
        const Vec3d at = random.point();
        const double size = std::exp2(5 * random.number() - 5);
        const Vec3d b = at + size * random.point();
        add_triangle(mesh, at, b, at + size * random.point());
    }
    return mesh;
}

/// Möller & Trumbore 1997, another formula than the tree's.
std::optional<double> ray_hit(const Vec3d& origin, const Vec3d& direction,
                              const std::array<Vec3d, 3>& corners) {
    const Vec3d u = corners[1] - corners[0];
    const Vec3d v = corners[2] - corners[0];
    const Vec3d across = direction.cross(v);
    const double determinant = u.dot(across);
    const Vec3d to_origin = origin - corners[0];
    const double b = to_origin.dot(across) / determinant;
    const double c = direction.dot(to_origin.cross(u)) / determinant;
    const double t = v.dot(to_origin.cross(u)) / determinant;
    if (!(b >= 0 && c >= 0 && b + c <= 1 && t >= 0)) return std::nullopt;
    return t;
}

/// 1e-12 of the mesh's size: a thousand times the rounding of distances, far below any mistake.
double tolerance_for(const Mesh& mesh) {
    double size = 0;
    for (const Vec3d& p : mesh.vertices_world) size = std::max(size, p.lpNorm<Eigen::Infinity>());
    return 1e-12 * std::max(size, 1.0);
}

void expect_true_answers(const Mesh& mesh, unsigned seed, int queries) {
    Random random(seed);
    const WorldBox box = bounding_box(mesh);
    const Vec3d middle = (box.min + box.max) / 2;
    const double reach = std::max(box.size().maxCoeff(), 1e-3);
    const double tolerance = tolerance_for(mesh);
    std::vector<KdTree> trees;
    for (const KdVariant variant : variants) trees.emplace_back(mesh, variant);
    for (int i = 0; i < queries; ++i) {
        const Vec3d p = middle + reach * random.point();
        const double expected = brute_force_distance(mesh, p);
        std::vector<std::pair<double, std::int32_t>> all;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            all.emplace_back(closest_point(p, corners_of(mesh, t)).squared_distance,
                             static_cast<std::int32_t>(t));
        std::ranges::sort(all);
        const Vec3d direction = random.point();
        std::optional<double> expected_t;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            if (const auto hit = ray_hit(p, direction, corners_of(mesh, t)))
                expected_t = std::min(*hit, expected_t.value_or(infinity));
        for (const KdTree& tree : trees) {
            const auto found = tree.closest(p);
            ASSERT_TRUE(found);
            ASSERT_NEAR(std::sqrt(found->closest.squared_distance), expected, tolerance);
            ASSERT_NEAR((p - found->closest.p).norm(), expected, tolerance);
            const ClosestPoint again = closest_point(p, corners_of(mesh, found->triangle));
            ASSERT_EQ(again.p, found->closest.p);
            ASSERT_EQ(again.feature, found->closest.feature);
            ASSERT_FALSE(tree.closest(p, expected * (1 - 1e-9) - tolerance));
            ASSERT_TRUE(tree.closest(p, expected * (1 + 1e-9) + tolerance));

            const std::size_t k = static_cast<std::size_t>(i) % 12;
            const auto nearest = tree.k_nearest(p, k);
            ASSERT_EQ(nearest.size(), std::min(k, all.size()));
            for (std::size_t n = 0; n < nearest.size(); ++n) {
                ASSERT_NEAR(std::sqrt(nearest[n].closest.squared_distance), std::sqrt(all[n].first),
                            tolerance);
                for (std::size_t m = 0; m < n; ++m)
                    ASSERT_NE(nearest[n].triangle, nearest[m].triangle);
            }

            const auto hit = tree.first_hit(p, direction);
            // 1e-9: rays that graze a triangle hit it by one formula and not by the other; none of
            // these seeds has one.
            ASSERT_EQ(hit.has_value(), expected_t.has_value());
            if (!hit) continue;
            ASSERT_NEAR(hit->t, *expected_t, 1e-9 * std::max(1.0, *expected_t));
        }
    }
}

TEST(KdTree, AgreesWithBruteForceOnRandomSoups) {
    for (unsigned seed = 1; seed <= 20; ++seed)
        expect_true_answers(random_soup(seed, 1 << (seed % 11)), seed, 60);
}

TEST(KdTree, AgreesWithBruteForceOnSampleMeshes) {
    for (const char* const name : {"torus", "knot", "seashell"})
        expect_true_answers(sample_mesh(name), 1, 40);
}

TEST(KdTree, AgreesWithBruteForceWhereAllTrianglesAreFlat) {
    Random random(3);
    Mesh mesh;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d flat(1, 1, 0);
        const Vec3d at = random.point().cwiseProduct(flat);
        add_triangle(mesh, at, at + 0.05 * random.point().cwiseProduct(flat),
                     at + 0.05 * random.point().cwiseProduct(flat));
    }
    expect_true_answers(mesh, 3, 60);
}

TEST(KdTree, AgreesWithBruteForceOnNeedles) {
    Random random(4);
    Mesh mesh;
    for (int i = 0; i < 1000; ++i) {
        const Vec3d a = random.point();
        const Vec3d b = random.point();
        add_triangle(mesh, a, b, a + 1e-3 * random.point());
    }
    expect_true_answers(mesh, 4, 60);
}

TEST(KdTree, AgreesWithBruteForceOnPointsAndLines) {
    Random random(5);
    Mesh points;
    Mesh line;
    for (int i = 0; i < 1000; ++i) {
        const Vec3d a = random.point();
        add_triangle(points, a, a, a);
        const double x = random.number();
        add_triangle(line, {x, 0, 0}, {x, 0, 0}, {x + 0.01 * random.number(), 0, 0});
    }
    expect_true_answers(points, 5, 60);
    expect_true_answers(line, 5, 60);
}

TEST(KdTree, AgreesWithBruteForceFarFromTheOrigin) {
    Mesh mesh = random_soup(6, 500);
    for (Vec3d& p : mesh.vertices_world) p += Vec3d(1e6, -3e6, 2e6);
    expect_true_answers(mesh, 6, 60);
}

TEST(KdTree, OneTriangleAnswers) {
    Mesh mesh;
    add_triangle(mesh, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    expect_true_answers(mesh, 7, 100);
}

// Splits cannot part such triangles; the builder must notice, at once and at no great depth.
TEST(KdTree, HundredThousandTrianglesInOneBoxMakeOneLeaf) {
    Mesh equal;
    Mesh same_box;
    Random random(8);
    for (int i = 0; i < 100000; ++i) {
        add_triangle(equal, {0, 0, 0}, {1, 0, 0}, {0, 1, 1});
        add_triangle(same_box, {-1, -1, -1}, {1, 1, 1}, random.point());
    }
    for (const KdVariant variant : variants) {
        for (const Mesh& mesh : {equal, same_box}) {
            const KdTree tree(mesh, variant);
            EXPECT_EQ(tree.node_count(), 1u);
            EXPECT_EQ(tree.reference_count(), mesh.triangles.size());
        }
        // Of equal ones the first is reported.
        const auto found = KdTree(equal, variant).closest({0.2, 0.2, 3});
        ASSERT_TRUE(found);
        EXPECT_EQ(found->triangle, 0);
        const auto nearest = KdTree(equal, variant).k_nearest({0.2, 0.2, 3}, 3);
        for (int n = 0; n < 3; ++n) EXPECT_EQ(nearest[n].triangle, n);
    }
}

// Boxes one in the other, each half the last one's size: every split leaves one behind.
TEST(KdTree, NestedTrianglesAreBoundedInDepth) {
    Mesh mesh;
    for (int i = 0; i < 900; ++i) {
        const double size = std::exp2(-i);
        add_triangle(mesh, {0, 0, 0}, {size, 0, 0}, {0, size, size});
    }
    for (const KdVariant variant : variants) {
        const KdTree tree(mesh, variant);
        EXPECT_LE(tree.reference_count(), 5 * mesh.triangles.size());
        const auto found = tree.closest({-1, -1, -1});
        ASSERT_TRUE(found);
        EXPECT_EQ(found->closest.squared_distance, 3);
        EXPECT_EQ(found->triangle, 0);
    }
}

TEST(KdTree, IsTheSameOnOneThread) {
    const Mesh mesh = sample_mesh("sphere6");
    for (const KdVariant variant : variants) {
        const KdNodes on_all = build_kd_nodes(mesh, variant);
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        const KdNodes on_one = build_kd_nodes(mesh, variant);
        EXPECT_EQ(on_all.triangles, on_one.triangles);
        ASSERT_EQ(on_all.nodes.size(), on_one.nodes.size());
        for (std::size_t i = 0; i < on_all.nodes.size(); ++i) {
            EXPECT_EQ(on_all.nodes[i].left_end, on_one.nodes[i].left_end);
            EXPECT_EQ(on_all.nodes[i].right_begin, on_one.nodes[i].right_begin);
        }
    }
}

// No hole along edges and at vertices: from inside a closed surface every ray leaves it.
TEST(KdTree, RaysThroughVerticesAndEdgesOfASphereHit) {
    const Mesh mesh = sample_mesh("sphere6");
    const Vec3d origin(0.1, -0.05, 0.02);
    for (const KdVariant variant : variants) {
        const KdTree tree(mesh, variant);
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto [a, b, c] = corners_of(mesh, t);
            for (const Vec3d& target : {a, Vec3d((a + b) / 2), Vec3d(0.3 * b + 0.7 * c)}) {
                const auto hit = tree.first_hit(origin, target - origin);
                ASSERT_TRUE(hit);
                ASSERT_NEAR(hit->t, 1, 1e-12); // the rounding of a few products of numbers near 1
            }
        }
    }
}

TEST(KdTree, RaysMissBehindTheirOriginAndBeyondTheirEnd) {
    Mesh mesh;
    add_triangle(mesh, {0, 0, 1}, {1, 0, 1}, {0, 1, 1});
    const KdTree tree(mesh);
    const Vec3d origin(0.2, 0.2, 0);
    EXPECT_EQ(tree.first_hit(origin, {0, 0, 2})->t, 0.5);
    EXPECT_TRUE(tree.first_hit(origin, {0, 0, 1}, 1));
    EXPECT_FALSE(tree.first_hit(origin, {0, 0, 1}, 0.99));
    EXPECT_FALSE(tree.first_hit(origin, {0, 0, -1}));
    EXPECT_FALSE(tree.first_hit(origin, {1, 0, 0}));
}

struct Work {
    KdStatistics band;
    KdStatistics rays;
};

Work work_of(const Mesh& mesh, KdVariant variant) {
    const KdTree tree(mesh, variant);
    const WorldBox box = bounding_box(mesh);
    Random random(9);
    Work work;
    for (int i = 0; i < 2000; ++i) {
        // A hundredth of the box from the surface.
        const std::size_t t = static_cast<std::size_t>(
            (random.number() + 1) / 2 * static_cast<double>(mesh.triangles.size() - 1));
        const Vec3d near = corners_of(mesh, t)[0] + 0.01 * box.size().maxCoeff() * random.point();
        tree.closest(near, infinity, &work.band);
        const Vec3d origin = box.min + (random.point() + Vec3d::Ones()).cwiseProduct(box.size());
        tree.first_hit(origin, near - origin, infinity, &work.rays);
    }
    return work;
}

// The thesis also claims fewer visited nodes. That is not so here: nodes with fewer triangles of
// their own are split further. What is tested falls by far more than what is visited grows.
void expect_fewest_tests(const Mesh& mesh) {
    const Work overlapping = work_of(mesh, KdVariant::Overlapping);
    // Measured: at most 0.08 of what objects at nodes test, 0.43 of what split references do.
    for (const auto& [variant, share] :
         {std::pair(KdVariant::ObjectsAtNodes, 0.15), std::pair(KdVariant::SplitReferences, 0.6)}) {
        const Work classic = work_of(mesh, variant);
        EXPECT_LT(static_cast<double>(overlapping.band.objects_tested),
                  share * static_cast<double>(classic.band.objects_tested));
        EXPECT_LT(static_cast<double>(overlapping.rays.objects_tested),
                  share * static_cast<double>(classic.rays.objects_tested));
        EXPECT_LT(overlapping.band.nodes_visited - classic.band.nodes_visited,
                  classic.band.objects_tested - overlapping.band.objects_tested);
    }
}

TEST(KdTree, OverlappingNodesTestFewerTrianglesOfTheKnot) {
    expect_fewest_tests(sample_mesh("knot"));
}

TEST(KdTree, OverlappingNodesTestFewerTrianglesOfTheBunny) {
    const auto path = std::filesystem::path(ISOCAST_SHARED_DATA) / "bunny-closed.obj";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no bunny-closed.obj";
    expect_fewest_tests(read_mesh(path));
}

} // namespace
} // namespace isocast::test
