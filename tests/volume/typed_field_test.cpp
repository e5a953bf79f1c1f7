// Dense fields of samples of any type.
// SPDX-License-Identifier: MPL-2.0
#include "volume/typed_field.h"

#include "random_fields.h"
#include "temporary_folder.h"
#include "typed_bytes.h"
#include "volume/errors.h"

#include <gmock/gmock.h>

namespace isocast::test {
namespace {

using ::testing::HasSubstr;

/// A field of `values` stored as `type`.
TypedField typed(const Index3& size, std::span<const double> values, SampleType type,
                 std::endian order = std::endian::native, double slope = 1, double intercept = 0) {
    const auto bytes = std::make_shared<const std::string>(bytes_of(values, type, order));
    return {"a.file",
            GridSpace::uniform(1),
            size,
            {.type = type,
             .byte_order = order,
             .slope = slope,
             .intercept = intercept,
             .bytes = std::as_bytes(std::span(*bytes)),
             .owner = bytes}};
}

TEST(TypedField, EqualsADenseFieldOfItsValuesInEveryBoxAndLevel) {
    Random random(1);
    for (const SampleType type : all_sample_types)
        for (const std::endian order : {std::endian::little, std::endian::big})
            for (int i = 0; i < 60; ++i) {
                const IndexBox extent{Index3::Zero(), random_box(random, 0, 0, 12).size()};
                const std::vector<double> values =
                    random_values(random, type, static_cast<std::size_t>(extent.sample_count()));
                // Powers of two, so that the expected values round once, too.
                const double slope = i % 3 == 0 ? 0.25 : 1;
                const double intercept = i % 3 == 0 ? -8 : 0;
                std::vector<float> expected;
                for (const double value : values)
                    expected.push_back(static_cast<float>(slope * value + intercept));
                const DenseField dense(GridSpace::uniform(1), extent, expected);
                const TypedField field =
                    typed(extent.size(), values, type, order, slope, intercept);
                const int level = random_int(random, 0, 3);
                const IndexBox box = random_box(random, -12, 12, 20);
                ASSERT_EQ(copied(field, box, level), copied(dense, box, level))
                    << name_of(type) << " level " << level << " of " << extent.hi.transpose()
                    << " from " << box.lo.transpose() << " to " << box.hi.transpose();
                const ValueRange range = field.value_range(box);
                EXPECT_EQ(range.min, dense.value_range(box).min);
                EXPECT_EQ(range.max, dense.value_range(box).max);
                EXPECT_FALSE(field.half_width_world());
                EXPECT_EQ(field.active_boxes(), std::vector<IndexBox>{extent});
            }
}

TEST(TypedField, SamplesNeedNotBeAligned) {
    const std::vector<double> values{1, -2, 3, -4, 5, -6};
    const auto bytes = std::make_shared<const std::string>(
        std::string("x").append(bytes_of(values, SampleType::Double, std::endian::native)));
    const TypedField field("a", GridSpace::uniform(1), {3, 2, 1},
                           {.type = SampleType::Double,
                            .bytes = std::as_bytes(std::span(*bytes)).subspan(1),
                            .owner = bytes});
    EXPECT_EQ(copied(field, field.extent()), (std::vector<float>{1, -2, 3, -4, 5, -6}));
}

// Found when the sample is asked for: opening reads none of a large file.
TEST(TypedField, ASampleThatIsNoNumberIsNamed) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    for (const SampleType type : {SampleType::Float, SampleType::Double})
        for (const std::endian order : {std::endian::little, std::endian::big}) {
            std::vector<double> values(4 * 5 * 6, 1.0);
            values[1 + 4 * (2 + 5 * 3)] = nan;
            values[3 + 4 * (4 + 5 * 5)] = -infinity;
            const TypedField field = typed({4, 5, 6}, values, type, order);
            EXPECT_EQ(copied(field, {{0, 0, 0}, {4, 5, 3}}), std::vector<float>(60, 1.0F));
            const auto error = [&](const IndexBox& box, int level) {
                return message_of<InputError>([&] { copied(field, box, level); });
            };
            EXPECT_EQ(error({{0, 0, 0}, {4, 5, 6}}, 0),
                      "a.file: sample (1, 2, 3) is nan, not a finite number");
            EXPECT_EQ(error({{5, 5, 5}, {9, 9, 9}}, 0),
                      "a.file: sample (3, 4, 5) is -inf, not a finite number");
            EXPECT_EQ(error({{2, 2, 3}, {3, 3, 4}}, 1),
                      "a.file: sample (3, 4, 5) is -inf, not a finite number");
            EXPECT_THAT(message_of<InputError>([&] { field.value_range(field.extent()); }),
                        HasSubstr("not a finite number"));
        }
    // Too large for a float32, though each part is finite.
    const TypedField scaled =
        typed({1, 1, 1}, std::vector{200.0}, SampleType::UInt8, std::endian::native, 1e38, 0);
    EXPECT_THAT(message_of<InputError>([&] { copied(scaled, scaled.extent()); }),
                HasSubstr("(0, 0, 0) is inf"));
}

TEST(TypedField, RefusesAWrongNumberOfBytesAndMapsWithoutInverse) {
    const std::vector<double> values(24, 0.0);
    EXPECT_THAT(message_of<InputError>([&] {
                    typed({2, 3, 5}, values, SampleType::Int16);
                }),
                HasSubstr("60 bytes, not 48"));
    EXPECT_THAT(message_of<InputError>([&] {
                    typed({24, 1, 0}, values, SampleType::UInt8);
                }),
                HasSubstr("none along an axis"));
    const std::string bytes = bytes_of(values, SampleType::UInt8, std::endian::native);
    for (const Mat3d& linear :
         {Mat3d(Mat3d::Zero()), Mat3d(Vec3d(1, 0, 1).asDiagonal()), Mat3d(Mat3d::Ones()),
          Mat3d(Mat3d::Constant(std::numeric_limits<double>::quiet_NaN()))}) {
        GridSpace space;
        space.world_from_index.linear() = linear;
        EXPECT_THAT(message_of<InputError>([&] {
                        TypedField("a", space, {2, 3, 4},
                                   {.type = SampleType::UInt8,
                                    .bytes = std::as_bytes(std::span(bytes)),
                                    .owner = {}});
                    }),
                    HasSubstr("no inverse"));
    }
}

} // namespace
} // namespace isocast::test
