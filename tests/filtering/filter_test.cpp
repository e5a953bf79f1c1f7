// Filters by name, and the control samples that they make.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/filter.h"

#include "../volume/random_fields.h"
#include "../volume/temporary_folder.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"

#include <gmock/gmock.h>

#include <array>

namespace isocast {
namespace {

using namespace test;
using testing::HasSubstr;

constexpr std::array filters{Filter::Linear, Filter::BSpline, Filter::Interpolating, Filter::Exact,
                             Filter::CatmullRom};

std::shared_ptr<const DenseField> dense(Random& random, const IndexBox& extent) {
    return std::make_shared<DenseField>(random_dense(random, extent));
}

TEST(Filter, NamesGoBothWays) {
    for (const Filter filter : filters) EXPECT_EQ(filter_from_name(filter_name(filter)), filter);
    EXPECT_EQ(filter_from_name("catmull-rom"), Filter::CatmullRom);
    EXPECT_EQ(message_of<InputError>([] { filter_from_name("cubic"); }),
              "unknown filter 'cubic' (known: linear, bspline, interpolating, exact, catmull-rom)");
}

TEST(ControlSamples, AreTheSamplesThemselvesWhereTheKernelAsksForThem) {
    Random random(1);
    const auto field = dense(random, {Index3::Zero(), Index3::Constant(5)});
    for (const Filter filter : {Filter::Linear, Filter::BSpline, Filter::CatmullRom}) {
        EXPECT_EQ(control_samples(field, filter), field);
    }
}

TEST(QuasiInterpolant, IsTheStencilAtEveryLevel) {
    Random random(2);
    const auto field = dense(random, {Index3(-7, 3, 0), Index3(30, 29, 41)});
    const auto control = control_samples(field, Filter::Interpolating);
    for (int i = 0; i < 60; ++i) {
        const int level = i % 3;
        const IndexBox box = random_box(random, -12, 30, 20); // also beyond the extent
        const std::vector<float> c = copied(*control, box, level);
        std::size_t at = 0;
        for_each_sample(box, [&](const Index3& index) {
            const auto f = [&](const Index3& offset) {
                return double{sample(*field, (1 << level) * (index + offset))};
            };
            double laplacian = -6 * f(Index3::Zero());
            for (int axis = 0; axis < 3; ++axis) {
                laplacian += f(Index3::Unit(axis)) + f(-Index3::Unit(axis));
            }
            // Samples below 1, differences below 2: 6 u w < 12 * 6e-8 (see value_range), and the
            // result's own rounding of 2e-7.
            EXPECT_NEAR(c[at++], f(Index3::Zero()) - laplacian / 6, 1e-6);
        });
    }
}

TEST(QuasiInterpolant, IsTheSameInOnePieceAsSampleBySample) {
    Random random(3);
    const auto field = dense(random, {Index3::Zero(), Index3(9, 7, 150)});
    const auto control = control_samples(field, Filter::Interpolating);
    const IndexBox box{Index3(-2, -2, -3), Index3(8, 9, 160)}; // in three slabs
    const std::vector<float> c = copied(*control, box);
    std::size_t at = 0;
    for_each_sample(box, [&](const Index3& index) {
        ASSERT_EQ(c[at++], sample(*control, index)) << index.transpose();
    });
}

TEST(QuasiInterpolant, KeepsConstantsAndMirrorsExactly) {
    const IndexBox extent{Index3::Zero(), Index3::Constant(12)};
    // 0.1 is no float: a sum of six would round.
    const auto constant = std::make_shared<DenseField>(GridSpace::uniform(1), extent,
                                                       std::vector(12 * 12 * 12, 0.1f));
    for (const float c : copied(*control_samples(constant, Filter::Interpolating), extent)) {
        EXPECT_EQ(c, 0.1f);
    }
    Random random(4);
    const auto field = dense(random, extent);
    const std::vector<float> c = copied(*control_samples(field, Filter::Interpolating), extent);
    for (int axis = 0; axis < 3; ++axis) {
        const auto mirrored = [&](const Index3& index) {
            Index3 other = index;
            other[axis] = 11 - index[axis];
            return static_cast<std::size_t>(other.x() + 12 * (other.y() + 12 * other.z()));
        };
        std::vector<float> values;
        for_each_sample(extent,
                        [&](const Index3& i) { values.push_back(field->values()[mirrored(i)]); });
        const auto mirror =
            std::make_shared<DenseField>(GridSpace::uniform(1), extent, std::move(values));
        const std::vector<float> m =
            copied(*control_samples(mirror, Filter::Interpolating), extent);
        std::size_t at = 0;
        for_each_sample(extent, [&](const Index3& i) { ASSERT_EQ(m[at++], c[mirrored(i)]); });
    }
}

TEST(QuasiInterpolant, RangesHoldEverySampleAndAreReached) {
    Random random(5);
    for (int i = 0; i < 200; ++i) {
        const double offset = i % 2 == 0 ? 0 : random_real(random, -1e6, 1e6);
        const IndexBox extent = random_box(random, -5, 5, 12);
        std::vector<float> values(static_cast<std::size_t>(extent.sample_count()));
        for (float& value : values) {
            value = static_cast<float>(offset + (random_int(random, 0, 1) == 0 ? -1 : 1));
        }
        const auto field =
            std::make_shared<DenseField>(GridSpace::uniform(1), extent, std::move(values));
        const auto control = control_samples(field, Filter::Interpolating);
        const IndexBox box = random_box(random, -8, 8, 10);
        const ValueRange range = control->value_range(box);
        for (const float c : copied(*control, box)) {
            ASSERT_GE(c, range.min);
            ASSERT_LE(c, range.max);
        }
    }
    // Samples of alternating sign, all six neighbours the opposite: c = 3 f, the range's ends.
    const IndexBox extent{Index3::Zero(), Index3::Constant(8)};
    std::vector<float> values;
    for_each_sample(extent, [&](const Index3& i) { values.push_back(i.sum() % 2 == 0 ? 1 : -1); });
    const auto field =
        std::make_shared<DenseField>(GridSpace::uniform(1), extent, std::move(values));
    const auto control = control_samples(field, Filter::Interpolating);
    EXPECT_NEAR(sample(*control, {4, 4, 4}), 3, 1e-6); // 6 u w, as above
    const ValueRange range = control->value_range({Index3::Constant(3), Index3::Constant(5)});
    EXPECT_NEAR(range.max, 3, 2e-6); // and 10 u w of slack
    EXPECT_NEAR(range.min, -3, 2e-6);
}

TEST(QuasiInterpolant, ActiveBoxesHoldWhatIsNotBackgroundAndDoNotOverlap) {
    Random random(6);
    for (int round = 0; round < 8; ++round) {
        const auto field =
            std::make_shared<SparseField>(GridSpace::uniform(1), 3.0, Outside::Background,
                                          random_blocks(random, 2, round == 0 ? 0.01 : 0.15, 3));
        const auto control = control_samples(field, Filter::Interpolating);
        const std::vector<IndexBox> boxes = control->active_boxes();
        const IndexBox all = dilated(field->extent(), 10, 10);
        std::vector<int> times(static_cast<std::size_t>(all.sample_count()));
        const Index3 n = all.size();
        for (const IndexBox& box : boxes) {
            for_each_sample(box, [&](const Index3& index) {
                ASSERT_TRUE(all.contains(index));
                const Index3 i = index - all.lo;
                ++times[static_cast<std::size_t>(i.x() + n.x() * (i.y() + n.y() * i.z()))];
            });
        }
        const std::vector<float> c = copied(*control, all);
        for (std::size_t i = 0; i < c.size(); ++i) {
            ASSERT_LE(times[i], 1);
            if (times[i] == 0) {
                ASSERT_EQ(c[i], 3);
            }
        }
    }
}

TEST(ExactPrefilter, SolvesForTheSamplesUpToTheBorder) {
    Random random(7);
    for (const Index3& n :
         {Index3(1, 1, 1), Index3(2, 3, 1), Index3(5, 17, 33), Index3(40, 16, 9)}) {
        const IndexBox extent{Index3(-3, 2, 5), Index3(-3, 2, 5) + n};
        const auto field = dense(random, extent);
        const auto control = control_samples(field, Filter::Exact);
        EXPECT_EQ(control->extent(), extent);
        std::size_t at = 0;
        for_each_sample(extent, [&](const Index3& index) {
            double value = 0;
            for_each_sample({Index3::Constant(-1), Index3::Constant(2)}, [&](const Index3& offset) {
                const double weight = std::pow(4, 3 - offset.cwiseAbs().sum()) / 216;
                value += weight * sample(*control, index + offset);
            });
            // Each axis at most triples values and earlier errors, and rounds its results, at most
            // 3, 9 and 27, to float: 3 * 27 * 6e-8. Measured 4e-7.
            EXPECT_NEAR(value, field->values()[at++], 5e-6);
        });
    }
}

TEST(ExactPrefilter, RefusesBandsAndTooMuchMemory) {
    const std::shared_ptr<const FieldSource> band = sampled(builtin_field("sphere"), 16, 3);
    EXPECT_THAT(message_of<InputError>([&] { control_samples(band, Filter::Exact); }),
                HasSubstr("'interpolating'"));
    const std::shared_ptr<const FieldSource> field = sampled(builtin_field("sphere"), 64);
    EXPECT_THAT(
        message_of<ResourceError>([&] { control_samples(field, Filter::Exact, {}, 0x1p20 - 1); }),
        HasSubstr("64 x 64 x 64"));
    EXPECT_NO_THROW(control_samples(field, Filter::Exact, {}, 0x1p20));
}

TEST(ExactPrefilter, TellsItsProgressAndStops) {
    const std::shared_ptr<const FieldSource> field = sampled(builtin_field("sphere"), 64);
    EXPECT_THROW(control_samples(field, Filter::Exact,
                                 [](std::string_view, double fraction) {
                                     EXPECT_GE(fraction, 0);
                                     EXPECT_LE(fraction, 1);
                                     throw Interrupted();
                                 }),
                 Interrupted);
}

} // namespace
} // namespace isocast
