// No part of the surface is missed: cells against brute force, and features far smaller than the
// coarse cells that hide them from the thesis's builder.
// SPDX-License-Identifier: MPL-2.0
#include "adaptive_fields.h"
#include "bench/adaptive/thesis_builders.h"

namespace isocast::test {
namespace {

/// Levels that build_adaptive divides whatever they hold.
constexpr int divided_levels = 3;

/// Below the first levels a cell is divided if a triangle meets it, and only then. Touches closer
/// than 1e-9 of a cell may be seen or not: distances of doubles up to 2^7 round at 1e-14.
void expect_divided_at_surface(const Mesh& mesh, const HashedOctree& tree) {
    for (int level = 1; level <= tree.depth(); ++level) {
        const Mesh scaled = moved(mesh, std::exp2(-level), Vec3d::Zero());
        const int across_levels = tree.depth() - level;
        const CellSet must = surface_cells(scaled, across_levels, -1e-9);
        const CellSet may = surface_cells(scaled, across_levels, 1e-9);
        int missed = 0;
        int needless = 0;
        for_each_sample({Index3::Zero(), Index3::Constant(1 << across_levels)},
                        [&](const Index3& at) {
                            const bool is_divided = tree.is_divided({at * (1 << level), level});
                            missed += must.contains(at) && !is_divided;
                            needless += !may.contains(at) && is_divided;
                        });
        EXPECT_EQ(missed, 0) << "level " << level;
        if (across_levels >= divided_levels) {
            EXPECT_EQ(needless, 0) << "level " << level;
        }
    }
}

HashedOctree divided_at_surface(const ExactDistance& distance, int depth) {
    return build_adaptive(distance, {.depth = depth, .max_error_cells = std::nullopt});
}

TEST(AdaptiveFeatures, CellsOfClosedMeshesAreThoseThatTrianglesMeet) {
    for (const std::string& name : sample_mesh_names()) {
        SCOPED_TRACE(name);
        const MeshInCells input(mesh_in_cells(sample_mesh(name), 6));
        expect_divided_at_surface(input.mesh(), divided_at_surface(input.distance(), 6));
    }
}

// Needles, slivers, whole numbers at which triangles lie in the faces of cells.
TEST(AdaptiveFeatures, CellsOfRandomTrianglesAreThoseThatTheyMeet) {
    constexpr int depth = 6;
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Mesh soup;
        for (int t = 0; t < 12; ++t) {
            const Vec3d middle = random_point(random, 8, 56);
            const double size = std::exp2(random_real(random, -8, 3));
            for (int k = 0; k < 3; ++k) {
                Vec3d corner = middle + size * random_point(random, -1, 1);
                if (seed % 4 == 0) corner = corner.array().round();
                soup.vertices_world.push_back(corner);
            }
            soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
        }
        const MeshInCells input(soup);
        expect_divided_at_surface(input.mesh(), divided_at_surface(input.distance(), depth));
    }
}

// A ball's boundary meets a cube if the cube's nearest point is in the ball and its farthest is
// not.
TEST(AdaptiveFeatures, CellsOfASphereByFormulaAreThoseThatItMeets) {
    constexpr int depth = 6;
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        Random random(seed);
        const Vec3d centre = random_point(random, 16, 48);
        const double radius = std::exp2(random_real(random, -3, 3.5));
        const LipschitzDistance distance(
            [&](const Vec3d& p) { return sphere_distance(p, centre, radius); });
        const HashedOctree tree = divided_at_surface(distance, depth);
        int missed = 0;
        int found = 0;
        for_each_sample({Index3::Zero(), Index3::Constant(1 << depth)}, [&](const Index3& at) {
            const Vec3d lo = at.cast<double>();
            const Vec3d hi = (lo.array() + 1).matrix();
            const Vec3d nearest = centre.cwiseMax(lo).cwiseMin(hi) - centre;
            const Vec3d farthest = (centre - lo).cwiseAbs().cwiseMax((hi - centre).cwiseAbs());
            if (nearest.norm() > radius || farthest.norm() < radius) return;
            ++found;
            missed += !tree.find({at, 0}).has_value();
        });
        EXPECT_EQ(missed, 0) << seed;
        EXPECT_GT(found, 0) << seed;
    }
}

/// Of needles [max_error]: a third of it is the radius of a ball inside, less a thirtieth.
constexpr double thickness = 0.4;

/// A needle is found if a finest cell meets it, or the field is negative at one of its points.
int missed_of(const std::vector<Mesh>& needles, const HashedOctree& tree) {
    int missed = 0;
    for (const Mesh& needle : needles) {
        Vec3d middle = Vec3d::Zero();
        for (const Vec3d& p : needle.vertices_world) middle += p / 4;
        bool is_found = false;
        for (const Vec3d& corner : needle.vertices_world)
            for (double t = 0; t < 1 && !is_found; t += 0x1p-6) {
                const Vec3d p = corner + t * (middle - corner);
                is_found = tree.leaf_at(p).level == 0 || tree.value_at(p) < 0;
            }
        missed += !is_found;
    }
    return missed;
}

// Each holds a ball wider than a quarter of the error: of the cells around it the one that has the
// ball's centre is reached deeper than hidden_share, an eighth of the error, from all of its faces,
// even where an edge or a corner of cells lies in the needle. The thesis's builder sees those alone
// that hold a node of the coarse lattice.
TEST(AdaptiveFeatures, NeedlesInFreeSpaceAreFoundThatCornersDoNotSee) {
    constexpr int depth = 7;
    int all_count = 0;
    int missed_by_thesis = 0;
    for (unsigned seed = 0; seed < 4; ++seed) {
        const double max_error = seed % 2 == 0 ? 0.5 : 1.5;
        const std::vector<Mesh> needles = needles_in_cells(depth, thickness * max_error, seed);
        Mesh all;
        for (const Mesh& needle : needles) add_mesh(needle, all);
        const MeshInCells input(all);
        for (const OctreeFilter filter : octree_filters)
            EXPECT_EQ(missed_of(needles,
                                build_adaptive(input.distance(), {.depth = depth,
                                                                  .filter = filter,
                                                                  .max_error_cells = max_error})),
                      0);
        EXPECT_EQ(missed_of(needles, divided_at_surface(input.distance(), depth)), 0);
        all_count += static_cast<int>(needles.size());
        missed_by_thesis += missed_of(needles, built_top_down(input.distance(), depth, 0).tree);
    }
    EXPECT_GT(all_count, 200);
    EXPECT_GT(missed_by_thesis, all_count * 9 / 10);
}

TEST(AdaptiveFeatures, NeedlesBesideABigSphereAreFound) {
    constexpr int depth = 7;
    constexpr double max_error = 0.5;
    const Vec3d centre = Vec3d::Constant(64);
    constexpr double radius = 30;
    std::vector<Mesh> needles = needles_in_cells(depth, thickness * max_error, 2);
    // Off the sphere by more than the error, within which its own field may hide them.
    std::erase_if(needles, [&](const Mesh& needle) {
        return std::ranges::any_of(needle.vertices_world, [&](const Vec3d& p) {
            return (p - centre).norm() < radius + 2 * max_error;
        });
    });
    Mesh all = moved(subdivided_sphere(5), radius, centre);
    for (const Mesh& needle : needles) add_mesh(needle, all);
    const MeshInCells input(all);
    for (const OctreeFilter filter : octree_filters)
        EXPECT_EQ(missed_of(needles,
                            build_adaptive(
                                input.distance(),
                                {.depth = depth, .filter = filter, .max_error_cells = max_error})),
                  0);
}

// A cell whose corners are on both sides is good for the face alone; the speck's surface must be
// within the error too.
TEST(AdaptiveFeatures, ASpeckNearAFlatFaceInsideOneCoarseCellIsFound) {
    constexpr int depth = 7;
    constexpr double max_error = 1;
    for (const double height : {6.0, 12.0}) { // over the face
        const double radius = 0.2 * max_error;
        // Below z = 84 solid; specks over the middles of cells of edge 16, which the face halves.
        const auto at = [&](const Vec3d& p) {
            ExactDistance::Sample nearest{p.z() - 84, Vec3d::UnitZ()};
            const Vec3d middle((std::floor(p.x() / 16) + 0.5) * 16,
                               (std::floor(p.y() / 16) + 0.5) * 16, 84 + height);
            const ExactDistance::Sample speck = sphere_distance(p, middle, radius);
            return speck.distance < nearest.distance ? speck : nearest;
        };
        const LipschitzDistance distance(at, 0.05);
        const HashedOctree tree =
            build_adaptive(distance, {.depth = depth, .max_error_cells = max_error});
        const ThesisTree thesis = built_top_down(distance, depth, 0);
        for (int y = 24; y < 128; y += 16)
            for (int x = 24; x < 128; x += 16) {
                const Vec3d middle(x, y, 84 + height);
                // On all of the speck's surface the field is within the error of 0.
                for (int k = 0; k < 6; ++k) {
                    const Vec3d p = middle + (k < 3 ? radius : -radius) * Vec3d::Unit(k % 3);
                    EXPECT_LE(std::abs(tree.value_at(p)), max_error) << p.transpose();
                }
            }
        // The face alone, divided down to the finest as it is, does not show them.
        EXPECT_GT(thesis.tree.value_at({24, 24, 84 + height}), 3 * max_error);
    }
}

} // namespace
} // namespace isocast::test
