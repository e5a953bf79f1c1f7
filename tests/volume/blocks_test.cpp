// Tests of the active blocks against brute force over the samples, and of bricks cut from fields.
// SPDX-License-Identifier: MPL-2.0
#include "volume/blocks.h"

#include "random_fields.h"
#include "volume/analytic_fields.h"
#include "volume/bricks.h"
#include "volume/errors.h"
#include "volume/sparsify.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace isocast {
namespace {

using test::Random;

/// By the definition, block by block and cell by cell, over the blocks of `box` [block coordinates]
/// and the cells with samples in `cells`.
ActiveBlocks brute_force(const FieldSource& field, float iso, const IndexBox& blocks,
                         const IndexBox& cells) {
    ActiveBlocks active;
    test::for_each_sample(blocks, [&](const Index3& b) {
        const Index3 lo = (8 * b.array() - 1).matrix(); // thesis eq. 5.1: 8b - 1 … 8b + 9
        const auto values = test::copied(field, {lo, (lo.array() + 11).matrix()});
        const auto [min, max] = std::ranges::minmax(values);
        if (min <= iso && iso <= max) active.coordinates.push_back(b);
    });
    test::for_each_sample({cells.lo, (cells.hi.array() - 1).matrix()}, [&](const Index3& at) {
        const IndexBox cell{at, (at.array() + 2).matrix()};
        const auto corners = test::copied(field, cell);
        const auto inside =
            std::ranges::count_if(corners, [iso](float value) { return value < iso; });
        if (inside != 0 && inside != 8) active.surface_box = bounding_box(active.surface_box, cell);
    });
    return active;
}

void expect_equal(const ActiveBlocks& found, const ActiveBlocks& expected) {
    EXPECT_EQ(found.coordinates, expected.coordinates);
    EXPECT_EQ(found.surface_box, expected.surface_box);
}

TEST(ActiveBlocks, EqualBruteForceInADenseField) {
    Random random(1);
    for (int i = 0; i < 6; ++i) {
        const IndexBox extent = test::random_box(random, -20, 10, 50);
        // Noise of which the greatest values are rare, so that some blocks are active and some not.
        std::vector<float> values(static_cast<std::size_t>(extent.sample_count()));
        for (float& value : values) {
            value = static_cast<float>(std::pow(test::random_real(random, 0, 1), 400.0));
        }
        const DenseField field(GridSpace::uniform(1), extent, values);
        const ActiveBlocks expected = brute_force(field, 0.5f, blocks_over(extent), extent);
        expect_equal(find_active_blocks(field, 0.5f), expected);
    }
}

TEST(ActiveBlocks, EqualBruteForceForAnalyticFieldsThatCrossTheirBorder) {
    for (const std::string name : {"gyroid", "saddle", "marschner-lobb", "cylinder"}) {
        const auto field = sampled(builtin_field(name), 41);
        for (const float iso : {0.0f, 0.1f}) {
            const IndexBox extent = field->extent();
            expect_equal(find_active_blocks(*field, iso),
                         brute_force(*field, iso, blocks_over(extent), extent));
        }
    }
}

TEST(ActiveBlocks, EqualBruteForceInABandIncludingBlocksThatAreNotStored) {
    for (const std::string name : {"sphere", "torus"}) {
        const SparseField field = to_sparse(*sampled(builtin_field(name), 61, 3));
        const auto half_width = static_cast<float>(*field.half_width_world());
        const IndexBox around = dilated(field.extent(), 16, 16);
        // Also near the rim of the band, where blocks beside the stored ones become active.
        for (const float iso : {0.0f, 0.6f * half_width, -0.98f * half_width}) {
            const ActiveBlocks expected = brute_force(field, iso, blocks_over(around), around);
            EXPECT_FALSE(expected.coordinates.empty());
            expect_equal(find_active_blocks(field, iso), expected);
        }
    }
}

TEST(ActiveBlocks, OfAnUnsignedSparseFieldIncludeTheStepToItsBackground) {
    Random random(2);
    FieldBlocks blocks = test::random_blocks(random, 1, 0.3, 1.0f);
    for (FieldBlock& block : blocks) {
        for (float& value : block.values) value = std::abs(value) / 2;
    }
    const SparseField field(GridSpace::uniform(1), 1.0, Outside::Background, blocks);
    const IndexBox around = dilated(field.extent(), 16, 16);
    expect_equal(find_active_blocks(field, 0.75f),
                 brute_force(field, 0.75f, blocks_over(around), around));
}

TEST(ActiveBlocks, PlateauAtTheIsoValueIsActiveAndHasNoSurface) {
    const DenseField field(GridSpace::uniform(1), {{0, 0, 0}, {16, 8, 8}},
                           std::vector<float>(16 * 8 * 8, 0.0f));
    const ActiveBlocks active = find_active_blocks(field, 0.0f);
    EXPECT_EQ(active.coordinates, (std::vector<Index3>{{0, 0, 0}, {1, 0, 0}}));
    EXPECT_TRUE(active.surface_box.is_empty());
    EXPECT_TRUE(find_active_blocks(field, 0.5f).coordinates.empty());
}

TEST(ActiveBlocks, SurfaceBoxOfASphereIsItsBox) {
    // Radius 1 over [-1.5, 1.5] with 31 samples: the surface lies at 15 ± 10 voxels.
    const auto field = sampled(builtin_field("sphere"), 32); // an odd number of cells
    const ActiveBlocks active = find_active_blocks(*field, 0);
    const double voxel = field->space().voxel_size_world();
    for (int axis = 0; axis < 3; ++axis) {
        const double lo = active.surface_box.lo[axis] * voxel - 1.5;
        const double hi = (active.surface_box.hi[axis] - 1) * voxel - 1.5;
        // The sphere's top cell is found if one of its corners is inside: within 1.1 voxels.
        EXPECT_NEAR(lo, -1, 1.1 * voxel);
        EXPECT_NEAR(hi, 1, 1.1 * voxel);
    }
}

TEST(ActiveBlocks, DoNotDependOnTheNumberOfThreads) {
    const SparseField field = to_sparse(*sampled(builtin_field("torus"), 61, 3));
    const ActiveBlocks many = find_active_blocks(field, 0);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    expect_equal(find_active_blocks(field, 0), many);
}

TEST(ActiveBlocks, StopWhenInterrupted) {
    const auto field = sampled(builtin_field("gyroid"), 200);
    EXPECT_THROW(
        find_active_blocks(*field, 0, [](std::string_view, double) { throw Interrupted(); }),
        Interrupted);
}

TEST(Bricks, AreThoseThatHoldAnActiveBlock) {
    Random random(3);
    ActiveBlocks blocks;
    std::vector<Index3> expected;
    for (int i = 0; i < 200; ++i) {
        const Index3 block(test::random_int(random, -9, 9), test::random_int(random, -9, 9),
                           test::random_int(random, -9, 9));
        blocks.coordinates.push_back(block);
        const Index3 brick = floor_div(8 * block, 32);
        if (std::ranges::find(expected, brick) == expected.end()) expected.push_back(brick);
    }
    std::ranges::sort(expected, zyx_less);
    EXPECT_EQ(bricks_of(blocks), expected);
}

TEST(Bricks, HoldTheSamplesOfTheFieldWithTheApron) {
    const SparseField sparse = to_sparse(*sampled(builtin_field("torus"), 61, 3));
    const auto analytic = sampled(builtin_field("gyroid"), 41);
    for (const FieldSource* field :
         std::initializer_list<const FieldSource*>{&sparse, analytic.get()}) {
        for (const Index3& brick : {Index3(0, 0, 0), Index3(1, 0, 1), Index3(-1, 1, 2)}) {
            std::vector<float> values(brick_samples * brick_samples * brick_samples);
            cut_brick(*field, brick, values);
            std::size_t next = 0;
            for (int z = -1; z <= 33; ++z) {
                for (int y = -1; y <= 33; ++y) {
                    for (int x = -1; x <= 33; ++x) {
                        ASSERT_EQ(values[next++], sample(*field, 32 * brick + Index3(x, y, z)));
                    }
                }
            }
            ASSERT_EQ(next, values.size());
        }
    }
}

} // namespace
} // namespace isocast
