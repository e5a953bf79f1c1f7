// Tests of the sparse field: its samples, and what it has where no block is stored.
// SPDX-License-Identifier: MPL-2.0
#include "volume/sparse_field.h"

#include "random_fields.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <map>
#include <tuple>

namespace isocast {
namespace {

using test::Random;

constexpr float background = 2.5f;

/// The documented rule, word by word: one sample at a time, with a walk to lower x.
class Oracle {
public:
    Oracle(const FieldBlocks& blocks, Outside outside) : outside_(outside) {
        for (const FieldBlock& block : blocks) blocks_[key(block.coordinate)] = block;
    }

    float operator()(const Index3& index) const {
        Index3 block = floor_div(index, block_size);
        const Index3 within = index - block_size * block;
        if (const auto found = blocks_.find(key(block)); found != blocks_.end()) {
            return found->second
                .values[static_cast<std::size_t>(within.x() + 8 * within.y() + 64 * within.z())];
        }
        if (outside_ == Outside::Background) return background;
        for (; block.x() >= -20; --block.x()) {
            const auto found = blocks_.find(key(block));
            if (found != blocks_.end())
                return found->second.values[7] < 0 ? -background : background;
        }
        return background;
    }

private:
    static std::tuple<int, int, int> key(const Index3& b) { return {b.x(), b.y(), b.z()}; }
    std::map<std::tuple<int, int, int>, FieldBlock> blocks_;
    Outside outside_;
};

class SparseFieldRule : public testing::TestWithParam<Outside> {};

TEST_P(SparseFieldRule, GivesEverySampleAtEveryLevel) {
    Random random(1);
    for (int i = 0; i < 60; ++i) {
        const FieldBlocks blocks = test::random_blocks(random, 2, 0.2, background);
        const SparseField field(GridSpace::uniform(1), background, GetParam(), blocks);
        const Oracle oracle(blocks, GetParam());
        for (int j = 0; j < 6; ++j) {
            const int level = test::random_int(random, 0, 5);
            const IndexBox box =
                test::random_box(random, -(30 >> level), 20 >> level, level == 0 ? 25 : 12);
            const std::vector<float> values = test::copied(field, box, level);
            std::size_t next = 0;
            test::for_each_sample(box, [&](const Index3& at) {
                ASSERT_EQ(values[next++], oracle((1 << level) * at)) << at.transpose();
            });
        }
    }
}

TEST_P(SparseFieldRule, ValueRangeHoldsEverySample) {
    Random random(2);
    for (int i = 0; i < 60; ++i) {
        const SparseField field(GridSpace::uniform(1), background, GetParam(),
                                test::random_blocks(random, 2, 0.2, background));
        for (int j = 0; j < 6; ++j) {
            const IndexBox box = test::random_box(random, -30, 20, 20);
            const auto [min, max] = std::ranges::minmax(test::copied(field, box));
            const ValueRange range = field.value_range(box);
            EXPECT_LE(range.min, min);
            EXPECT_GE(range.max, max);
            // No wider than the samples of the blocks that the box touches.
            const IndexBox over = blocks_over(box);
            const auto [block_min, block_max] = std::ranges::minmax(
                test::copied(field, {block_size * over.lo, block_size * over.hi}));
            EXPECT_EQ(range.min, block_min);
            EXPECT_EQ(range.max, block_max);
        }
    }
}

TEST_P(SparseFieldRule, ActiveBoxesHoldTheBlocksEachOnce) {
    Random random(3);
    const FieldBlocks blocks = test::random_blocks(random, 3, 0.4, background);
    const SparseField field(GridSpace::uniform(1), background, GetParam(), blocks);
    std::map<std::tuple<int, int, int>, int> times;
    for (const IndexBox& box : field.active_boxes()) {
        const IndexBox over = blocks_over(box);
        EXPECT_EQ(box, (IndexBox{block_size * over.lo, block_size * over.hi}));
        test::for_each_sample(over, [&](const Index3& b) { ++times[{b.x(), b.y(), b.z()}]; });
    }
    EXPECT_EQ(times.size(), blocks.size());
    for (const FieldBlock& block : blocks) {
        const Index3& b = block.coordinate;
        EXPECT_EQ((times[{b.x(), b.y(), b.z()}]), 1);
    }
}

INSTANTIATE_TEST_SUITE_P(Both, SparseFieldRule,
                         testing::Values(Outside::SignedBackground, Outside::Background));

TEST(SparseField, SortsItsBlocksAndKeepsTheirContents) {
    Random random(4);
    FieldBlocks blocks = test::random_blocks(random, 3, 0.5, background);
    const SparseField field(GridSpace::uniform(1), background, Outside::SignedBackground, blocks);
    std::ranges::sort(blocks, zyx_less, &FieldBlock::coordinate);
    ASSERT_EQ(field.blocks().size(), blocks.size());
    std::int64_t active = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        EXPECT_EQ(field.blocks()[i].coordinate, blocks[i].coordinate);
        EXPECT_EQ(field.blocks()[i].values, blocks[i].values);
        EXPECT_EQ(field.blocks()[i].active, blocks[i].active);
        active += static_cast<std::int64_t>(blocks[i].active.count());
    }
    EXPECT_EQ(field.active_voxel_count(), active);
}

TEST(SparseField, UnsignedExtentHasABorderOfBackground) {
    FieldBlock block;
    block.coordinate = {-1, 0, 1};
    const SparseField plain(GridSpace::uniform(1), background, Outside::Background, {block});
    EXPECT_EQ(plain.extent(), (IndexBox{{-10, -2, 6}, {2, 10, 18}}));
    EXPECT_EQ(plain.half_width_world(), std::nullopt);
    const SparseField level_set(GridSpace::uniform(1), background, Outside::SignedBackground,
                                {block});
    EXPECT_EQ(level_set.extent(), (IndexBox{{-8, 0, 8}, {0, 8, 16}}));
    EXPECT_EQ(level_set.half_width_world(), background);
}

TEST(SparseField, WithoutBlocksIsOutsideEverywhere) {
    const SparseField field(GridSpace::uniform(1), background, Outside::SignedBackground, {});
    EXPECT_TRUE(field.extent().is_empty());
    EXPECT_EQ(sample(field, {100, -3, 5}), background);
}

TEST(SparseField, RefusesABlockTwiceAndASignedFieldWithoutABand) {
    FieldBlock block;
    block.coordinate = {1, 2, 3};
    EXPECT_THROW(SparseField(GridSpace::uniform(1), 1, Outside::SignedBackground, {block, block}),
                 InputError);
    EXPECT_THROW(SparseField(GridSpace::uniform(1), 0, Outside::SignedBackground, {block}),
                 InputError);
}

} // namespace
} // namespace isocast
