// Every word of the block table against brute force.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/block_table.h"

#include "../volume/random_fields.h"
#include "filtering/filter.h"
#include "filtering/reconstruct.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"
#include "volume/sparsify.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

namespace isocast {
namespace {

using test::Random;

using Key = std::array<int, 3>;

Key key_of(const Index3& p) {
    return {p.x(), p.y(), p.z()};
}

/// Chebyshev distance to the nearest of `some`, at most `limit`.
int distance_to(const std::set<Key>& some, const Index3& p, int limit) {
    int nearest = limit;
    for (const Key& key : some) {
        const Index3 other(key[0], key[1], key[2]);
        nearest = std::min(nearest, (other - p).cwiseAbs().maxCoeff());
    }
    return nearest;
}

/// Expects the function to be negative (or nowhere negative) at random points of a block.
void expect_sign(const FieldSource& control, Kernel kernel, float iso, const Index3& block,
                 bool is_inside, Random& random) {
    // Beyond its extent a field without a band is none: rays end there.
    const IndexBox extent = control.extent();
    const Vec3d lo = extent.lo.cast<double>();
    const Vec3d hi = (extent.hi.array() - 1).matrix().cast<double>();
    for (int i = 0; i < 4; ++i) {
        const Vec3d p =
            block_size * block.cast<double>() + test::random_point(random, 0, block_size);
        if (!control.half_width_world() && ((p - lo).minCoeff() < 0 || (hi - p).minCoeff() < 0))
            continue;
        ASSERT_EQ(kernel_value(control, p, kernel) < iso, is_inside) << p.transpose();
    }
}

void expect_table_right(const FieldSource& samples, const FieldSource& control, Kernel kernel,
                        float iso) {
    const BlockRanges ranges = find_block_ranges(control, kernel);
    const std::vector<ActivePage> active = active_pages(ranges, iso);
    const BlockTable table = make_block_table(samples, ranges, active, iso);
    std::set<Key> blocks;
    std::set<Key> pages;
    for (const Index3& b : find_active_blocks(control, kernel, iso).coordinates) {
        blocks.insert(key_of(b));
        pages.insert(key_of(floor_div(b, page_blocks)));
    }
    ASSERT_EQ(table.block_count, int(blocks.size()));
    ASSERT_EQ(table.words.size(), static_cast<std::size_t>(table.pages.prod()) + 64 * pages.size());

    Random random(7);
    std::set<std::uint32_t> numbers;
    const IndexBox all{table.first_page, table.first_page + table.pages};
    std::size_t page_number = 0;
    test::for_each_sample(all, [&](const Index3& page) {
        const std::uint32_t word = table.words[page_number++];
        if (!pages.contains(key_of(page))) {
            ASSERT_EQ(word & word_active, 0u);
            ASSERT_NE(word & word_of_page, 0u);
            // Exact, since the table holds all pages; without a surface nothing bounds it.
            if (!pages.empty()) {
                ASSERT_EQ(int(word & word_number), distance_to(pages, page, 1 << 20));
            }
            for (int place = 0; place < blocks_per_page; place += 7)
                expect_sign(control, kernel, iso,
                            page_blocks * page + Index3(place % 4, place / 4 % 4, place / 16),
                            (word & word_inside) != 0, random);
            return;
        }
        ASSERT_NE(word & word_active, 0u);
        const std::size_t first = word & word_number;
        ASSERT_LE(first + blocks_per_page, table.words.size());
        for (int place = 0; place < blocks_per_page; ++place) {
            const Index3 block = page_blocks * page + Index3(place % 4, place / 4 % 4, place / 16);
            ASSERT_EQ(place, place_in_page(place % 4, place / 4 % 4, place / 16));
            const std::uint32_t block_word = table.words[first + static_cast<std::size_t>(place)];
            const bool is_active = blocks.contains(key_of(block));
            ASSERT_EQ((block_word & word_active) != 0, is_active) << block.transpose();
            if (is_active) {
                ASSERT_TRUE(numbers.insert(block_word & word_number).second);
                continue;
            }
            ASSERT_EQ(block_word & word_of_page, 0u);
            // Within a page and its neighbours five is all that can be known.
            ASSERT_EQ(int(block_word & word_number), distance_to(blocks, block, page_blocks + 1))
                << block.transpose();
            expect_sign(control, kernel, iso, block, (block_word & word_inside) != 0, random);
        }
    });
    // Each block has a number below the count, and in the order of pages and places.
    if (!numbers.empty()) {
        EXPECT_EQ(*numbers.rbegin(), numbers.size() - 1);
    }
    std::uint32_t next = 0;
    for (const ActivePage& page : active) {
        const Index3 p = ranges.pages[page.page].coordinate - table.first_page;
        const std::uint32_t first =
            table.words[static_cast<std::size_t>(p.x() + table.pages.x() *
                                                             (p.y() + table.pages.y() * p.z()))] &
            word_number;
        for (std::uint32_t place = 0; place < 64; ++place) {
            if ((page.blocks >> place & 1U) != 0) {
                EXPECT_EQ(table.words[first + place], word_active | next++);
            }
        }
    }
}

TEST(BlockTable, IsRightForADenseField) {
    for (const std::string name : {"sphere", "gyroid", "marschner-lobb"}) {
        for (const Kernel kernel : {Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom}) {
            const auto field = sampled(builtin_field(name), 75);
            expect_table_right(*field, *field, kernel, 0);
        }
    }
}

TEST(BlockTable, IsRightForABandAndItsRim) {
    const auto field =
        std::make_shared<SparseField>(to_sparse(*sampled(builtin_field("torus"), 150, 3)));
    const auto half_width = static_cast<float>(*field->half_width_world());
    const auto control = control_samples(field, Filter::Interpolating);
    for (const float iso : {0.0F, 0.6F * half_width, -0.98F * half_width}) {
        expect_table_right(*field, *field, Kernel::BSpline, iso);
        expect_table_right(*field, *control, Kernel::BSpline, iso);
    }
}

TEST(BlockTable, IsRightWhereAFewBlocksLieFarApart) {
    // Specks, of the smallest kind that is seen; between them cubes of many sizes.
    Random random(8);
    for (int round = 0; round < 3; ++round) {
        const IndexBox extent{Index3(-70, -40, -90), Index3(90, 60, 75)};
        std::vector<float> values(static_cast<std::size_t>(extent.sample_count()), 1.0F);
        for (int i = 0; i < 12; ++i)
            values[static_cast<std::size_t>(test::random_int(random, 0, int(values.size()) - 1))] =
                -9;
        // The same inside out.
        if (round == 2) {
            for (float& value : values) value = -value;
        }
        const DenseField field(GridSpace::uniform(1), extent, values);
        expect_table_right(field, field, Kernel::BSpline, 0);
    }
}

TEST(BlockTable, OfAFieldWithoutASurfaceIsOnePage) {
    const auto field = sampled(builtin_field("sphere"), 20);
    for (const float iso : {-100.0F, 100.0F}) {
        const BlockRanges ranges = find_block_ranges(*field, Kernel::BSpline);
        const BlockTable table = make_block_table(*field, ranges, {}, iso);
        EXPECT_EQ(table.block_count, 0);
        ASSERT_EQ(table.words.size(), 1u);
        EXPECT_EQ((table.words[0] & word_inside) != 0, iso > 0);
    }
}

TEST(BlockTable, RefusesASurfaceThatSpansTooMuch) {
    BlockRanges ranges;
    for (const int at : {0, 1 << 15}) {
        BlockPage page;
        page.coordinate = Index3::Constant(at);
        ranges.pages.push_back(page);
    }
    const auto field = sampled(builtin_field("sphere"), 20);
    EXPECT_THROW(make_block_table(*field, ranges, {{0, 1}, {1, 1}}, 0), ResourceError);
}

} // namespace
} // namespace isocast
