// What the field errs by: on the surface, where it is proved, and beside it.
// SPDX-License-Identifier: MPL-2.0
#include "adaptive_fields.h"

namespace isocast::test {
namespace {

/// Values are floats no larger than the root, rounded when they are sampled, constrained and
/// interpolated; the points are doubles.
double rounding_of(const HashedOctree& tree) {
    return 3 * 0x1p-24 * tree.root().size();
}

struct Errors {
    double worst = 0;  // [max_error]
    double beyond = 0; // share of points that err by more than max_error
};

Errors errors_of(const ExactDistance& distance, const HashedOctree& tree,
                 std::span<const Vec3d> points, double max_error) {
    Errors errors;
    ExactDistance::Hint hint = 0;
    for (const Vec3d& p : points) {
        const double error = std::abs(tree.value_at(p) - distance.at(p, hint).distance);
        errors.worst = std::max(errors.worst, error / max_error);
        errors.beyond +=
            (error > max_error + rounding_of(tree)) / static_cast<double>(points.size());
    }
    return errors;
}

std::vector<Vec3d> scattered(std::vector<Vec3d> points, double reach, Random& random) {
    for (Vec3d& p : points)
        p += random_real(random, 0, reach) * random_point(random, -1, 1).normalized();
    return points;
}

class AdaptiveError : public ::testing::TestWithParam<std::string> {
protected:
    static Mesh mesh() {
        const std::string& name = GetParam();
        return name.find('.') == std::string::npos ? sample_mesh(name)
                                                   : read_mesh(shared_data(name));
    }
    static bool is_there() {
        return GetParam().find('.') == std::string::npos ||
               std::filesystem::exists(shared_data(GetParam()));
    }
};

TEST_P(AdaptiveError, IsWithinWhatIsAllowedOnAllOfTheSurface) {
    if (!is_there()) GTEST_SKIP() << "not there";
    constexpr int depth = 7;
    const MeshInCells input(mesh_in_cells(mesh(), depth));
    for (const OctreeFilter filter : octree_filters) {
        // The greatest that finest cells keep by Lipschitz's bound, and a coarser one.
        for (const double max_error : {std::numbers::sqrt3 / 2, 3.0}) {
            const HashedOctree tree = build_adaptive(
                input.distance(), {.depth = depth, .filter = filter, .max_error_cells = max_error});
            Random random(1);
            double worst = 0;
            for (const Vec3d& p : points_of_surface(input.mesh(), 100'000, random))
                worst = std::max(worst, std::abs(double{tree.value_at(p)}));
            EXPECT_LE(worst, max_error + rounding_of(tree)) << max_error;
        }
    }
}

// Off the surface the error is tested at points of each cell, and between them it can pass what is
// allowed. No bound is proved: at 100,000 points of each mesh were seen 1.40 times the error at
// worst, and 1 point in 1,000 beyond it.
TEST_P(AdaptiveError, IsRarelyAboveWhatIsAllowedNearTheSurface) {
    if (!is_there()) GTEST_SKIP() << "not there";
    constexpr int depth = 7;
    constexpr double max_error = 1;
    const MeshInCells input(mesh_in_cells(mesh(), depth, 6));
    for (const OctreeFilter filter : octree_filters) {
        const HashedOctree tree =
            build_adaptive(input.distance(), {.depth = depth,
                                              .filter = filter,
                                              .max_error_cells = max_error,
                                              .accurate_within_cells = 3 * max_error});
        Random random(2);
        const std::vector<Vec3d> points =
            scattered(points_of_surface(input.mesh(), 100'000, random), 3 * max_error, random);
        const Errors errors = errors_of(input.distance(), tree, points, max_error);
        EXPECT_LE(errors.worst, 1.75);
        EXPECT_LE(errors.beyond, 0.003);
    }
}

INSTANTIATE_TEST_SUITE_P(Meshes, AdaptiveError,
                         ::testing::Values("sphere6", "torus", "knot", "seashell",
                                           "bunny-closed.obj", "fandisk.obj"),
                         [](const auto& parameter) {
                             std::string name = parameter.param;
                             std::erase_if(name, [](char c) { return !std::isalnum(c); });
                             return name;
                         });

// A sphere by formula, its centre inside the root: the distance has a kink there.
TEST(AdaptiveErrorOfFormula, SphereKeepsItOnAndNearItsSurface) {
    constexpr int depth = 7;
    const Vec3d centre(63.3, 64.1, 65.7);
    constexpr double radius = 41.7;
    const LipschitzDistance distance(
        [&](const Vec3d& p) { return sphere_distance(p, centre, radius); });
    for (const OctreeFilter filter : octree_filters) {
        // The finest cells' own error, a sagitta of 3 / (8 radius), is below the least.
        for (const double max_error : {0.02, 0.5, 4.0}) {
            const HashedOctree tree = build_adaptive(distance, {.depth = depth,
                                                                .filter = filter,
                                                                .max_error_cells = max_error,
                                                                .accurate_within_cells = 3});
            Random random(3);
            std::vector<Vec3d> points;
            for (int i = 0; i < 100'000; ++i)
                points.push_back(centre + radius * random_point(random, -1, 1).normalized());
            EXPECT_LE(errors_of(distance, tree, points, max_error).worst,
                      1 + rounding_of(tree) / max_error)
                << max_error;
            // Tested at points alone; seen: 1.24.
            EXPECT_LE(errors_of(distance, tree, scattered(points, 3, random), max_error).worst, 1.5)
                << max_error;
        }
    }
}

// Of a smooth surface the error of linear cells goes with the square of their edge, and the number
// of those at the surface with one over that square.
TEST(AdaptiveErrorOfFormula, NodesOfASmoothSurfaceGrowAsOneOverTheError) {
    const LipschitzDistance distance(
        [](const Vec3d& p) { return sphere_distance(p, Vec3d::Constant(256.3), 200); });
    const auto node_count = [&](double max_error) {
        return static_cast<double>(
            build_adaptive(distance, {.depth = 9, .max_error_cells = max_error}).node_count());
    };
    // Edges are powers of two, which may take either number up to twice.
    const double ratio = node_count(0.01) / node_count(0.64);
    EXPECT_GT(ratio, 32);
    EXPECT_LT(ratio, 128);
}

} // namespace
} // namespace isocast::test
