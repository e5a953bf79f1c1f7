// Tests of to_sparse: same samples, no block too many.
// SPDX-License-Identifier: MPL-2.0
#include "volume/sparsify.h"

#include "random_fields.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

namespace isocast {
namespace {

using test::Random;

void expect_same_samples(const FieldSource& a, const FieldSource& b, const IndexBox& box) {
    EXPECT_EQ(test::copied(a, box), test::copied(b, box));
}

TEST(ToSparse, KeepsEverySampleOfABand) {
    for (const std::string& name : builtin_field_names()) {
        const auto field = sampled(builtin_field(name), 53, 2.5);
        expect_same_samples(*field, to_sparse(*field), field->extent());
    }
}

TEST(ToSparse, KeepsOnlyBlocksThatHoldThePartOfABand) {
    const auto field = sampled(builtin_field("sphere"), 80, 3);
    const SparseField sparse = to_sparse(*field);
    EXPECT_EQ(sparse.outside(), Outside::SignedBackground);
    EXPECT_EQ(sparse.half_width_world(), field->half_width_world());
    const auto half_width = static_cast<float>(*field->half_width_world());
    std::int64_t active = 0;
    test::for_each_sample(field->extent(), [&](const Index3& at) {
        if (std::abs(sample(*field, at)) < half_width) ++active;
    });
    EXPECT_EQ(sparse.active_voxel_count(), active);
    for (const FieldBlock& block : sparse.blocks()) {
        EXPECT_TRUE(block.active.any());
        for (std::size_t i = 0; i < block.values.size(); ++i) {
            EXPECT_EQ(block.active[i], std::abs(block.values[i]) < half_width);
        }
    }
}

TEST(ToSparse, StoresSignsThatTheBandDoesNotTell) {
    // A half space that begins without a band, as an open mesh's inside does: blocks along x are
    // outside, then noise of signs, then all inside, then all outside again, all beyond the band.
    const IndexBox extent{{0, 0, 0}, {64, 8, 8}};
    Random random(1);
    std::vector<float> values;
    test::for_each_sample(extent, [&](const Index3& at) {
        const bool inside = at.x() < 16   ? false
                            : at.x() < 24 ? test::random_int(random, 0, 1) == 0
                                          : at.x() < 48;
        values.push_back(inside ? -3.0f : 3.0f);
    });
    const DenseField field(GridSpace::uniform(1), extent, values, 3.0);
    const SparseField sparse = to_sparse(field);
    expect_same_samples(field, sparse, extent);
    EXPECT_LE(sparse.blocks().size(), 3U); // the noise, perhaps the first inside, the first outside
    EXPECT_EQ(sparse.active_voxel_count(), 0);
}

TEST(ToSparse, OfASparseFieldIsTheSameField) {
    Random random(2);
    const auto field = sampled(builtin_field("torus"), 47, 3);
    const SparseField once = to_sparse(*field);
    const SparseField twice = to_sparse(once);
    ASSERT_EQ(once.blocks().size(), twice.blocks().size());
    for (std::size_t i = 0; i < once.blocks().size(); ++i) {
        EXPECT_EQ(once.blocks()[i].coordinate, twice.blocks()[i].coordinate);
        EXPECT_EQ(once.blocks()[i].values, twice.blocks()[i].values);
        EXPECT_EQ(once.blocks()[i].active, twice.blocks()[i].active);
    }
}

TEST(ToSparse, WithoutABandKeepsEverySampleOfTheExtentActive) {
    Random random(3);
    const IndexBox extent{{-3, 2, 0}, {14, 13, 9}};
    const DenseField field = test::random_dense(random, extent);
    const SparseField sparse = to_sparse(field);
    expect_same_samples(field, sparse, extent);
    EXPECT_EQ(sparse.active_voxel_count(), extent.sample_count());
    EXPECT_EQ(sparse.half_width_world(), std::nullopt);
    float greatest = 0;
    test::for_each_sample(extent, [&](const Index3& at) {
        const bool on_border =
            (at.array() == extent.lo.array()).any() || (at.array() == extent.hi.array() - 1).any();
        if (on_border) greatest = std::max(greatest, std::abs(sample(field, at)));
    });
    EXPECT_EQ(sparse.background_world(), greatest);
    EXPECT_EQ(sample(sparse, extent.hi), greatest);
}

TEST(ToSparse, StopsWhenInterrupted) {
    const auto field = sampled(builtin_field("sphere"), 100, 3);
    EXPECT_THROW(to_sparse(*field, [](std::string_view, double) { throw Interrupted(); }),
                 Interrupted);
}

} // namespace
} // namespace isocast
