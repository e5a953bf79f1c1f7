// The comparison sees what it is there to see: a single sample off by a little.
// SPDX-License-Identifier: MPL-2.0
#include "exact_field.h"

namespace isocast::test {
namespace {

class ExactField : public ::testing::Test {
protected:
    static constexpr double half_width = 3;
    static constexpr double voxel = 0.15;

    /// Faults of the field after `change` had its way with each block until it returned true.
    template<class Change>
    Faults after(Change change) const {
        FieldBlocks blocks(field_.blocks().size());
        std::ranges::uninitialized_copy(field_.blocks(), blocks);
        for (FieldBlock& block : blocks)
            if (change(block)) break;
        const SparseField changed(field_.space(), field_.background_world(),
                                  Outside::SignedBackground, std::move(blocks));
        return faults_of(changed, known_, half_width);
    }
    /// The same for the first sample that `is_wanted`.
    template<class Wanted, class Change>
    Faults after_one(Wanted is_wanted, Change change) const {
        return after([&](FieldBlock& block) {
            for (int i = 0; i < samples_per_block; ++i)
                if (is_wanted(block, i)) {
                    change(block, i);
                    return true;
                }
            return false;
        });
    }

    Mesh mesh_ = noisy_sphere(50, 2);
    SparseField field_ =
        convert(check(mesh_), {.voxel_size_world = voxel, .half_width_voxels = half_width}).field;
    KnownField known_ = brute_force_field(mesh_, mesh_, Sides::Closed, field_.space(), half_width);
};

bool is_active(const FieldBlock& block, int i) {
    return block.active[i];
}

TEST_F(ExactField, HasNoFaultsAsItIs) {
    expect_no_faults(after([](FieldBlock&) { return true; }));
}

TEST_F(ExactField, SeesADistanceThatIsWrongByAFiftyThousandthOfAVoxel) {
    EXPECT_EQ(
        after_one(is_active, [](FieldBlock& block,
                                int i) { block.values[i] += static_cast<float>(2e-5 * voxel); })
            .wrong_distances,
        1);
}

TEST_F(ExactField, SeesAValueThatIsNoNumber) {
    EXPECT_EQ(after_one(is_active, [](FieldBlock& block, int i) { block.values[i] = NAN; })
                  .wrong_distances,
              1);
}

TEST_F(ExactField, SeesAWrongSignInTheBandAndBeyond) {
    const auto turn = [](FieldBlock& block, int i) { block.values[i] *= -1; };
    EXPECT_EQ(after_one(is_active, turn).wrong_signs, 1);
    // Not on the face at high x, whose sign stands for the blocks beyond.
    const auto is_beyond = [&](const FieldBlock& block, int i) {
        return !block.active[i] && i % block_size < block_size - 1 &&
               known_.box.contains(block_size * block.coordinate +
                                   Index3(i % 8, i / 8 % 8, i / 64));
    };
    EXPECT_EQ(after_one(is_beyond, turn).wrong_signs, 1);
}

TEST_F(ExactField, SeesASampleThatIsMissingFromTheBand) {
    const Faults faults = after_one(is_active, [](FieldBlock& block, int i) {
        block.active[i] = false;
        block.values[i] = std::copysign(static_cast<float>(half_width * voxel), block.values[i]);
    });
    EXPECT_EQ(faults.missing, 1);
    EXPECT_EQ(faults.wrong_signs, 0);
}

TEST_F(ExactField, SeesASampleThatIsActiveBeyondTheBand) {
    EXPECT_EQ(after_one([](const FieldBlock& block, int i) { return !block.active[i]; },
                        [](FieldBlock& block, int i) { block.active[i] = true; })
                  .beyond,
              1);
}

TEST_F(ExactField, SeesAMissingBlock) {
    const Faults faults = after([](FieldBlock& block) {
        block.coordinate.x() += 1000;
        return true;
    });
    EXPECT_GT(faults.missing, 0);
    EXPECT_GT(faults.beyond, 0);
}

} // namespace
} // namespace isocast::test
