// Tests of the dense field.
// SPDX-License-Identifier: MPL-2.0
#include "volume/dense_field.h"

#include "random_fields.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

namespace isocast {
namespace {

using test::Random;

TEST(DenseField, CopiesTheClampedSampleAtEveryLevel) {
    Random random(1);
    for (int i = 0; i < 300; ++i) {
        const IndexBox extent = test::random_box(random, -9, 3, 12);
        const DenseField field = test::random_dense(random, extent);
        const int level = test::random_int(random, 0, 3);
        const IndexBox box = test::random_box(random, -12, 8, 9);
        const std::vector<float> values = test::copied(field, box, level);
        const Index3 n = extent.size();
        std::size_t next = 0;
        test::for_each_sample(box, [&](const Index3& at) {
            const Index3 clamped =
                ((1 << level) * at).cwiseMax(extent.lo).cwiseMin((extent.hi.array() - 1).matrix()) -
                extent.lo;
            const int place = clamped.x() + n.x() * (clamped.y() + n.y() * clamped.z());
            ASSERT_EQ(values[next++], field.values()[static_cast<std::size_t>(place)]);
        });
    }
}

TEST(DenseField, ValueRangeIsThatOfItsSamples) {
    Random random(2);
    for (int i = 0; i < 300; ++i) {
        const DenseField field = test::random_dense(random, test::random_box(random, -9, 3, 12));
        const IndexBox box = test::random_box(random, -12, 8, 9);
        const auto [min, max] = std::ranges::minmax(test::copied(field, box));
        const ValueRange range = field.value_range(box);
        EXPECT_EQ(range.min, min);
        EXPECT_EQ(range.max, max);
    }
}

TEST(DenseField, SampleIsOneOfItsValues) {
    const DenseField field(GridSpace::uniform(1), {{1, 1, 1}, {3, 2, 2}}, {4, 5});
    EXPECT_EQ(sample(field, {1, 1, 1}), 4);
    EXPECT_EQ(sample(field, {2, 1, 1}), 5);
}

TEST(DenseField, RefusesAWrongNumberOfValues) {
    EXPECT_THROW(DenseField(GridSpace::uniform(1), {{0, 0, 0}, {2, 2, 2}}, {1, 2, 3}), InputError);
    EXPECT_THROW(DenseField(GridSpace::uniform(1), {{0, 0, 0}, {2, 0, 2}}, {}), InputError);
}

} // namespace
} // namespace isocast
