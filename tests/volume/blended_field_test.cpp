// Blends of fields against their definition, sample by sample.
// SPDX-License-Identifier: MPL-2.0
#include "volume/blended_field.h"

#include "random_fields.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"
#include "volume/sparsify.h"

namespace isocast::test {
namespace {

std::shared_ptr<const FieldSource> shell(double radius, double half_width_voxels) {
    AnalyticField field = sphere_field(Vec3d::Zero(), radius);
    field.half_extent_world = 1;
    return std::make_shared<SparseField>(
        to_sparse(*sampled(std::move(field), 65, half_width_voxels)));
}

TEST(BlendedField, IsTheBlendOfSamplesAtEveryLevel) {
    Random random(2);
    for (int run = 0; run < 20; ++run) {
        const auto a = random_sparse(random);
        const auto b = random_sparse(random);
        const double t = random_real(random, 0, 1);
        const BlendedField blend(a, b, t);
        const IndexBox box = random_box(random, -20, 20, 12);
        const int level = random_int(random, 0, 2);
        const auto of_a = copied(*a, box, level);
        const auto of_b = copied(*b, box, level);
        const auto of_blend = copied(blend, box, level);
        for (std::size_t i = 0; i < of_a.size(); ++i)
            EXPECT_EQ(of_blend[i], static_cast<float>((1 - t) * of_a[i] + t * of_b[i]));
        const ValueRange range = blend.value_range(box);
        for (const float value : copied(blend, box)) {
            EXPECT_GE(value, range.min);
            EXPECT_LE(value, range.max);
        }
    }
}

TEST(BlendedField, IsItsOperandBitForBitAtTheEnds) {
    Random random(3);
    const auto a = random_sparse(random);
    const auto b = random_sparse(random);
    const IndexBox box{Index3::Constant(-30), Index3::Constant(30)};
    EXPECT_EQ(copied(BlendedField(a, b, 0), box), copied(*a, box));
    EXPECT_EQ(copied(BlendedField(a, b, 1), box), copied(*b, box));
}

TEST(BlendedField, HasAllThatIsNotBackgroundInItsBoxes) {
    Random random(4);
    std::vector<BlendedField> blends;
    for (int run = 0; run < 6; ++run)
        blends.emplace_back(random_sparse(random), random_sparse(random), 0.3);
    blends.emplace_back(shell(0.5, 3), shell(0.7, 3), 0.5); // apart: a plateau between
    blends.emplace_back(shell(0.5, 3), shell(0.55, 4), 0.5);
    for (const BlendedField& blend : blends) {
        const std::vector<IndexBox> boxes = blend.active_boxes();
        const double half_width = blend.half_width_world().value();
        for_each_sample(blend.extent(), [&](const Index3& index) {
            int count = 0;
            for (const IndexBox& box : boxes) count += box.contains(index) ? 1 : 0;
            EXPECT_LE(count, 1);
            // The blend is rounded to float once more.
            if (std::abs(sample(blend, index)) < half_width * (1 - 0x1p-23)) {
                EXPECT_EQ(count, 1);
            }
        });
    }
}

TEST(BlendedField, SeesWhetherBandsMeet) {
    // Voxels of 1/32: bands reach to 0.5 + 3/32 < 0.7 - 3/32, and with six voxels beyond.
    EXPECT_TRUE(BlendedField(shell(0.5, 3), shell(0.7, 3), 0.5).has_plateau());
    EXPECT_FALSE(BlendedField(shell(0.5, 6), shell(0.7, 6), 0.5).has_plateau());
    const auto whole = std::shared_ptr<const FieldSource>(sampled(builtin_field("sphere"), 65));
    EXPECT_FALSE(BlendedField(whole, whole, 0.5).has_plateau());
}

TEST(BlendedField, RefusesTwoLatticesAndParametersBeyondTheEnds) {
    const auto a = std::shared_ptr<const FieldSource>(sampled(builtin_field("sphere"), 32));
    const auto b = std::shared_ptr<const FieldSource>(sampled(builtin_field("sphere"), 33));
    EXPECT_THROW(BlendedField(a, b, 0.5), InputError);
    EXPECT_THROW(BlendedField(a, a, 1.1), InputError);
    EXPECT_THROW(BlendedField(a, a, std::nan("")), InputError);
}

} // namespace
} // namespace isocast::test
