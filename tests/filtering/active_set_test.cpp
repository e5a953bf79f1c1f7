// Tests of the active blocks while the iso value moves: against their definition, block by block.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/active_set.h"

#include "../volume/random_fields.h"
#include "volume/analytic_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace isocast {
namespace {

using test::Random;
using Block = ActiveChange::Block;

/// By the definition: every block of every page.
std::set<Block> brute_force(const BlockRanges& ranges, float iso, float value_error) {
    std::set<Block> active;
    for (std::uint32_t page = 0; page < ranges.pages.size(); ++page) {
        for (std::uint32_t place = 0; place < blocks_per_page; ++place) {
            if ((ranges.pages[page].blocks >> place & 1U) == 0) continue;
            const auto [min, max] = ranges.pages[page].ranges[place];
            const float margin = 1e-5F * (max - min); // as blocks.h documents
            if (min - margin <= iso + value_error && iso - value_error <= max + margin)
                active.insert({page, place});
        }
    }
    return active;
}

std::set<Block> blocks_of(const std::vector<ActivePage>& pages) {
    std::set<Block> blocks;
    for (const ActivePage& page : pages)
        for (std::uint32_t place = 0; place < blocks_per_page; ++place)
            if ((page.blocks >> place & 1U) != 0)
                blocks.insert({static_cast<std::uint32_t>(page.page), place});
    return blocks;
}

std::vector<Block> difference(const std::set<Block>& a, const std::set<Block>& b) {
    std::vector<Block> only;
    std::ranges::set_difference(a, b, std::back_inserter(only));
    return only;
}

std::vector<Block> sorted(std::vector<Block> blocks) {
    std::ranges::sort(blocks);
    return blocks;
}

/// Ranges with ends among few values, so that many are equal; a third are plateaus.
BlockRanges random_ranges(Random& random, int page_count) {
    BlockRanges ranges;
    for (int i = 0; i < page_count; ++i) {
        BlockPage page;
        page.coordinate = {i, 0, 0};
        page.range = {2, -2};
        for (std::size_t place = 0; place < blocks_per_page; ++place) {
            if (test::random_int(random, 0, 3) == 0) continue;
            page.blocks |= std::uint64_t{1} << place;
            const auto a = static_cast<float>(test::random_int(random, -8, 8)) / 8;
            const auto b = static_cast<float>(test::random_int(random, -8, 8)) / 8;
            ValueRange& range = page.ranges[place];
            range = {std::min(a, b), std::max(a, b)};
            if (test::random_int(random, 0, 2) == 0) range.max = range.min;
            page.range = {std::min(page.range.min, range.min), std::max(page.range.max, range.max)};
        }
        ranges.pages.push_back(page);
    }
    return ranges;
}

TEST(ActiveSet, FollowsTheIsoValueAsBruteForceDoes) {
    int changes = 0;
    for (unsigned seed = 0; seed < 20; ++seed) {
        Random random(seed);
        const BlockRanges ranges = random_ranges(random, test::random_int(random, 0, 12));
        float iso = 0.25F;
        float value_error = 0;
        ActiveSet active(ranges, iso, value_error);
        std::set<Block> before = brute_force(ranges, iso, value_error);
        EXPECT_EQ(blocks_of(active.pages()), before);
        for (int move = 0; move < 60; ++move) {
            // At ends and plateaus, between them, beyond all; errors that grow and shrink.
            iso = test::random_int(random, 0, 1) == 0
                      ? static_cast<float>(test::random_int(random, -10, 10)) / 8
                      : static_cast<float>(test::random_real(random, -1.2, 1.2));
            value_error = test::random_int(random, 0, 1) == 0
                              ? 0
                              : static_cast<float>(test::random_real(random, 0, 0.3));
            const ActiveChange change = active.move_to(iso, value_error);
            const std::set<Block> after = brute_force(ranges, iso, value_error);
            ASSERT_EQ(sorted(change.came), difference(after, before)) << seed << " to " << iso;
            ASSERT_EQ(sorted(change.went), difference(before, after)) << seed << " to " << iso;
            ASSERT_EQ(blocks_of(active.pages()), after);
            ASSERT_EQ(blocks_of(active_pages(ranges, iso, value_error)), after);
            before = after;
            changes += static_cast<int>(change.came.size() + change.went.size());
        }
    }
    EXPECT_GT(changes, 10000);
}

TEST(ActiveSet, OfAFieldFollowsItsIsoValue) {
    const BlockRanges ranges =
        find_block_ranges(*sampled(builtin_field("gyroid"), 70), Kernel::BSpline);
    ActiveSet active(ranges, 0);
    for (const float iso : {0.1F, -0.3F, -0.3F, 5.0F, 0.0F}) {
        active.move_to(iso, 0.01F);
        EXPECT_EQ(blocks_of(active.pages()), brute_force(ranges, iso, 0.01F));
    }
    EXPECT_FALSE(active.pages().empty());
}

TEST(ActiveSet, DoesNotChangeWhereTheIsoValueStays) {
    Random random(1);
    const BlockRanges ranges = random_ranges(random, 5);
    ActiveSet active(ranges, 0.5F);
    const ActiveChange change = active.move_to(0.5F);
    EXPECT_TRUE(change.came.empty());
    EXPECT_TRUE(change.went.empty());
}

} // namespace
} // namespace isocast
