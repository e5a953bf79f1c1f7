// The tiles' lists of blocks against brute force: every pixel's ray with every active block.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/tile_lists.h"

#include "../volume/random_fields.h"
#include "hard_fields.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <bit>

namespace isocast {
namespace {

using test::Random;

/// Blocks over some pages with a surface, their ranges, and by number where each is.
struct Blocks {
    BlockRanges ranges;
    std::vector<ActivePage> active;
    std::vector<Index3> coordinates; // by number

    explicit Blocks(const FieldSource& field, float iso = 0)
        : ranges(find_block_ranges(field, Kernel::BSpline)), active(active_pages(ranges, iso)) {
        for (const ActivePage& page : active) {
            const Index3 first = page_blocks * ranges.pages[page.page].coordinate;
            for (std::uint64_t rest = page.blocks; rest != 0; rest &= rest - 1) {
                const int place = std::countr_zero(rest);
                coordinates.push_back(first + Index3(place % 4, place / 4 % 4, place / 16));
            }
        }
    }
};

/// Parameters t >= 0 of a ray in a block; x > y if it misses.
Eigen::Vector2d clip(const Ray& ray, const GridSpace& space, const Index3& block) {
    const Vec3d origin = space.to_index(ray.origin_world);
    const Vec3d direction = space.world_from_index.linear().inverse() * ray.direction_world;
    double t_in = 0;
    double t_out = 1e30;
    for (int axis = 0; axis < 3; ++axis) {
        const double lo = block_size * block[axis] - origin[axis];
        const double hi = lo + block_size;
        if (direction[axis] == 0) {
            // In a face between two blocks it is in the upper one alone, as in raycast.frag.
            if (lo > 0 || hi <= 0) return {1, 0};
            continue;
        }
        const double t0 = lo / direction[axis];
        const double t1 = hi / direction[axis];
        t_in = std::max(t_in, std::min(t0, t1));
        t_out = std::min(t_out, std::max(t0, t1));
    }
    return {t_in, t_out};
}

/// How many blocks rays met.
int expect_complete_and_ordered(const Blocks& blocks, const GridSpace& space, const Camera& camera,
                                int width, int height) {
    const TileLists tiles = list_blocks(blocks.ranges, blocks.active, space, camera, width, height);
    EXPECT_EQ(tiles.width, (width + 3) / 4);
    EXPECT_EQ(tiles.height, (height + 3) / 4);
    int met = 0;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const Ray ray = camera_ray(camera, width, height, x + 0.5, y + 0.5);
            // Tiles go from the bottom row up.
            const int tile = x / tile_pixels + tiles.width * ((height - 1 - y) / tile_pixels);
            const Eigen::Vector2i list = tiles.lists[static_cast<std::size_t>(tile)];
            std::vector<bool> is_listed(blocks.coordinates.size());
            double t_before = 0;
            for (int i = list[0]; i < list[0] + list[1]; ++i) {
                const auto number =
                    static_cast<std::size_t>(tiles.blocks[static_cast<std::size_t>(i)]);
                EXPECT_FALSE(is_listed[number]) << "twice";
                is_listed[number] = true;
                const Eigen::Vector2d t = clip(ray, space, blocks.coordinates[number]);
                // 1e-9: below it a ray touches an edge as far as doubles can tell.
                if (t.y() - t.x() < 1e-9) continue;
                EXPECT_GE(t.x(), t_before - 1e-9) << "pixel " << x << ", " << y;
                t_before = t.x();
            }
            for (std::size_t number = 0; number < blocks.coordinates.size(); ++number) {
                const Eigen::Vector2d t = clip(ray, space, blocks.coordinates[number]);
                if (t.y() - t.x() < 1e-9) continue;
                ++met;
                EXPECT_TRUE(is_listed[number]) << blocks.coordinates[number].transpose();
            }
        }
    }
    return met;
}

/// Cubes, anisotropic, sheared and left-handed voxels, far from the world's origin.
std::vector<GridSpace> spaces() {
    std::vector<GridSpace> all(4, GridSpace::uniform(1));
    all[1].world_from_index.linear() = Vec3d(0.4, 1.0, 3.0).asDiagonal();
    all[2].world_from_index.linear() << 0.9, 0.2, 0.0, -0.1, 1.1, 0.3, 0.1, 0.0, 0.8;
    all[3].world_from_index.linear() << 0.1, 0.9, 0.4, 1.3, 0.1, 0.3, 0.1, 0.0, 0.8;
    all[3].world_from_index.translation() = Vec3d(1000, -2000, 500);
    return all;
}

Camera random_camera(Random& random, const GridSpace& space, bool is_inside) {
    const Vec3d target = test::random_point(random, 0, 40);
    Vec3d eye = test::random_point(random, 0, 40);
    if (!is_inside) eye = target + 90 * test::random_point(random, -1, 1).normalized();
    Camera camera{.eye_world = space.to_world(eye), .target_world = space.to_world(target)};
    camera.up = test::random_point(random, -1, 1);
    if (test::random_int(random, 0, 1) == 0) {
        camera.projection = Projection::Orthographic;
        camera.height_world = test::random_real(random, 5, 60);
    } else {
        camera.fov_y_degrees = test::random_real(random, 5, is_inside ? 150 : 60);
    }
    return camera;
}

TEST(TileLists, HoldEveryBlockThatARayMeetsInTheRaysOrder) {
    const test::HardField field = test::tilted_torus(41, 1);
    const Blocks blocks(*field.control);
    ASSERT_GT(blocks.coordinates.size(), 20u);
    ASSERT_LT(blocks.coordinates.size(), 216u);
    Random random(2);
    for (const GridSpace& space : spaces()) {
        for (const bool is_inside : {false, true}) {
            int met = 0;
            for (int i = 0; i < 12; ++i) {
                // Sizes that are no multiple of a tile's too.
                const int width = test::random_int(random, 1, 25);
                const int height = test::random_int(random, 1, 25);
                met += expect_complete_and_ordered(
                    blocks, space, random_camera(random, space, is_inside), width, height);
                if (testing::Test::HasFailure()) return;
            }
            EXPECT_GT(met, 1000);
        }
    }
}

TEST(TileLists, AreOrderedForRaysAlongTheAxes) {
    const test::HardField field = test::smooth_noise(40, 2);
    const Blocks blocks(*field.control);
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        for (int axis = 0; axis < 3; ++axis) {
            for (const double sign : {-1.0, 1.0}) {
                // The eye on a corner of blocks; a picture of odd size has a ray through its
                // middle.
                Camera camera{.eye_world = Vec3d::Constant(16) + 40 * sign * Vec3d::Unit(axis),
                              .target_world = Vec3d::Constant(16),
                              .up = Vec3d::Unit((axis + 1) % 3),
                              .projection = projection,
                              .height_world = 32};
                EXPECT_GT(
                    expect_complete_and_ordered(blocks, GridSpace::uniform(1), camera, 17, 17),
                    500);
                camera.eye_world = Vec3d::Constant(16) - 8 * sign * Vec3d::Unit(axis);
                EXPECT_GT(
                    expect_complete_and_ordered(blocks, GridSpace::uniform(1), camera, 17, 17),
                    500);
            }
        }
    }
}

TEST(TileLists, RunsCoverTheTilesWithBlocksAndNoOthers) {
    const test::HardField field = test::tilted_torus(41, 3);
    const Blocks blocks(*field.control);
    const Camera camera{.eye_world = {90, 60, 110}, .target_world = {20, 20, 20}};
    const TileLists tiles =
        list_blocks(blocks.ranges, blocks.active, GridSpace::uniform(1), camera, 203, 101);
    std::vector<int> covered(tiles.lists.size());
    for (const Eigen::Vector4i& run : tiles.runs()) {
        ASSERT_LT(run[0], run[1]);
        for (int x = run[0]; x < run[1]; ++x)
            ++covered[static_cast<std::size_t>(x + tiles.width * run[2])];
    }
    int count = 0;
    for (std::size_t i = 0; i < covered.size(); ++i) {
        EXPECT_EQ(covered[i], tiles.lists[i][1] > 0 ? 1 : 0);
        count += covered[i];
    }
    EXPECT_GT(count, 100);
    EXPECT_LT(count, int(covered.size()));
}

TEST(TileLists, DoNotDependOnTheNumberOfThreads) {
    const test::HardField field = test::tilted_torus(41, 4);
    const Blocks blocks(*field.control);
    const Camera camera{.eye_world = {90, 60, 110}, .target_world = {20, 20, 20}};
    const auto listed = [&] {
        return list_blocks(blocks.ranges, blocks.active, GridSpace::uniform(1), camera, 203, 101);
    };
    const TileLists many = listed();
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const TileLists alone = listed();
    EXPECT_EQ(many.lists, alone.lists);
    EXPECT_EQ(many.blocks, alone.blocks);
}

TEST(TileLists, AreEmptyWhereThereIsNoBlockOrAllAreBehindTheEye) {
    const test::HardField field = test::tilted_torus(41, 5);
    const Camera away{.eye_world = {90, 20, 20}, .target_world = {120, 20, 20}};
    for (const auto& [iso, camera] :
         {std::pair(1e6F, Camera{.eye_world = {90, 20, 20}, .target_world = {20, 20, 20}}),
          std::pair(0.0F, away)}) {
        const Blocks blocks(*field.control, iso);
        const TileLists tiles =
            list_blocks(blocks.ranges, blocks.active, GridSpace::uniform(1), camera, 20, 20);
        EXPECT_TRUE(tiles.blocks.empty());
        EXPECT_TRUE(tiles.runs().empty());
        for (const Eigen::Vector2i& list : tiles.lists) EXPECT_EQ(list[1], 0);
    }
}

} // namespace
} // namespace isocast
