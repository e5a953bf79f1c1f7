// What the field errs by: on the surface, where it is proved, and beside it.
// SPDX-License-Identifier: MPL-2.0
#include "adaptive_fields.h"

#include <fmt/format.h>

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
    const MeshInCells input(mesh_in_cells(mesh(), depth), false);
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
            // It is what is asked for that is kept, not something much finer.
            EXPECT_GT(worst, max_error / 4) << max_error;
        }
    }
}

// Off the surface the error is tested at points of each cell, and between them it can pass what is
// allowed. No bound is proved; a point in a hundred and twice the error leave room for what was
// seen at 100,000 points: TODO.
TEST_P(AdaptiveError, IsRarelyAboveWhatIsAllowedNearTheSurface) {
    if (!is_there()) GTEST_SKIP() << "not there";
    constexpr int depth = 7;
    constexpr double max_error = 1;
    const MeshInCells input(mesh_in_cells(mesh(), depth, 6), false);
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
        if (std::getenv("SEEN"))
            fmt::print("{} {}: {:.3f} {:.5f}\n", GetParam(), static_cast<int>(filter), errors.worst,
                       errors.beyond);
        EXPECT_LE(errors.worst, 2);
        EXPECT_LE(errors.beyond, 0.01);
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
        for (const double max_error : {0.02, 0.5, 4.0}) {
            const HashedOctree tree = build_adaptive(distance, {.depth = depth,
                                                                .filter = filter,
                                                                .max_error_cells = max_error,
                                                                .accurate_within_cells = 3});
            Random random(3);
            std::vector<Vec3d> points;
            for (int i = 0; i < 100'000; ++i)
                points.push_back(centre + radius * random_point(random, -1, 1).normalized());
            // A finest cell of a sphere errs by the sagitta of its diagonal at most.
            const double least = 3.0 / (8 * (radius - 3));
            const double allowed = std::max(max_error, least);
            EXPECT_LE(errors_of(distance, tree, points, allowed).worst,
                      1 + rounding_of(tree) / allowed)
                << max_error;
            const Errors near = errors_of(distance, tree, scattered(points, 3, random), allowed);
            EXPECT_LE(near.worst, 1.1) << max_error; // no bound; seen TODO
        }
    }
}

// Linear: of a smooth surface a quarter of the error takes half the edge of cells, and so four
// times the cells at the surface.
TEST(AdaptiveErrorOfFormula, NodesOfASmoothSurfaceGrowAsOneOverTheError) {
    const LipschitzDistance distance(
        [](const Vec3d& p) { return sphere_distance(p, Vec3d::Constant(128.3), 100); });
    std::array<double, 3> nodes{};
    for (int i = 0; i < 3; ++i)
        nodes[static_cast<std::size_t>(i)] = static_cast<double>(
            build_adaptive(distance, {.depth = 8, .max_error_cells = 2 * std::pow(0.25, i)})
                .node_count());
    // Cells are powers of two, so that the number of a step is 4 or so: seen TODO.
    EXPECT_NEAR(nodes[1] / nodes[0], 4, 1.5);
    EXPECT_NEAR(nodes[2] / nodes[1], 4, 1.5);
}

} // namespace
} // namespace isocast::test
