// Whether the signs of a band fit together, and what to do if not.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/sign_check.h"

#include "distance_transform/progress_meter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace isocast {

namespace {

class SignCheck {
public:
    SignCheck(const FieldBlocks& blocks, std::span<const SampleBits> negative, double voxel_size)
        : blocks_(blocks), order_(zyx_order(blocks)),
          least_sum_(voxel_size * (1 + 1e-5)), // 1e-5: rounding to float
          coordinates_(blocks.size()), negative_(blocks.size()) {
        tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
            coordinates_[b] = block(b).coordinate;
            negative_[b] = negative.empty() ? negative_bits(block(b)) : negative[order_[b]];
        });
    }

    bool run() {
        constexpr std::size_t grain = 256;
        const tbb::blocked_range<std::size_t> all(0, blocks_.size(), grain);
        std::atomic<bool> is_consistent = true;
        tbb::parallel_for(all, [&](const auto& range) {
            if (is_consistent && !fits(range.begin(), range.end())) is_consistent = false;
        });
        return is_consistent;
    }

private:
    const FieldBlock& block(std::size_t b) const { return blocks_[order_[b]]; }

    /// Blocks begin … end - 1 with their neighbours at higher x, y and z.
    bool fits(std::size_t begin, std::size_t end) const {
        for (int axis = 0; axis < 3; ++axis) {
            // Neighbours of sorted blocks are sorted too: one search, then a walk.
            const Index3 step = Index3::Unit(axis);
            auto next = std::ranges::lower_bound(coordinates_, Index3(coordinates_[begin] + step),
                                                 zyx_less);
            for (std::size_t b = begin; b < end; ++b) {
                const Index3 wanted = coordinates_[b] + step;
                while (next != coordinates_.end() && zyx_less(*next, wanted)) ++next;
                if (!fits_within(b, axis)) return false;
                if (next != coordinates_.end() && *next == wanted &&
                    !fits_across(b, static_cast<std::size_t>(next - coordinates_.begin()), axis))
                    return false;
            }
        }
        for (std::size_t b = begin; b < end; ++b)
            if (!fits_row(b)) return false;
        return true;
    }

    bool are_far(float a, float b) const { return std::abs(a) + std::abs(b) > least_sum_; }

    bool fits_within(std::size_t b, int axis) const {
        constexpr std::uint64_t all_but_last_column = 0x7f7f7f7f7f7f7f7f;
        const auto& words = negative_[b].words;
        for (int z = 0; z < block_size; ++z) {
            std::uint64_t changes = 0;
            if (axis == 0) changes = (words[z] ^ words[z] >> 1) & all_but_last_column;
            if (axis == 1) changes = (words[z] ^ words[z] >> block_size) & ~std::uint64_t{0} >> 8;
            if (axis == 2) changes = z + 1 < block_size ? words[z] ^ words[z + 1] : 0;
            const int stride = axis == 0 ? 1 : axis == 1 ? block_size : block_size * block_size;
            for (; changes != 0; changes &= changes - 1) {
                const int i = 64 * z + std::countr_zero(changes);
                if (are_far(block(b).values[i], block(b).values[i + stride])) return false;
            }
        }
        return true;
    }

    /// The last layer of block b and the first of its neighbour.
    bool fits_across(std::size_t b, std::size_t neighbour, int axis) const {
        const auto& words = negative_[b].words;
        const auto& next = negative_[neighbour].words;
        const int stride = axis == 0 ? 1 : axis == 1 ? block_size : block_size * block_size;
        for (int z = 0; z < (axis == 2 ? 1 : block_size); ++z) {
            constexpr std::uint64_t first_column = 0x0101010101010101;
            std::uint64_t changes = 0; // at the samples of the neighbour
            if (axis == 0) changes = (words[z] >> 7 ^ next[z]) & first_column;
            if (axis == 1) changes = (words[z] >> 56 ^ next[z]) & 0xff;
            if (axis == 2) changes = words[block_size - 1] ^ next[0];
            for (; changes != 0; changes &= changes - 1) {
                const int near = 64 * z + std::countr_zero(changes);
                const int far = near + (block_size - 1) * stride;
                if (are_far(block(b).values[far], block(neighbour).values[near])) return false;
            }
        }
        return true;
    }

    /// What the field's rule gives beyond this block against the next stored one, or + at the end.
    bool fits_row(std::size_t b) const {
        const Index3& here = coordinates_[b];
        const bool is_row_end =
            b + 1 == blocks_.size() || coordinates_[b + 1].tail<2>() != here.tail<2>();
        const bool is_inside = is_inside_beyond(block(b));
        if (is_row_end) return !is_inside;
        return coordinates_[b + 1].x() == here.x() + 1 || is_inside == negative_[b + 1][0];
    }

    const FieldBlocks& blocks_;
    std::vector<std::uint32_t> order_; // by z, y, x: the numbers of blocks below are places in it
    double least_sum_;
    // Apart from the samples, so that the search touches little memory.
    std::vector<Index3> coordinates_;
    std::vector<SampleBits> negative_;
};

} // namespace

bool signs_are_consistent(const FieldBlocks& blocks, std::span<const SampleBits> negative,
                          double voxel_size_world) {
    return SignCheck(blocks, negative, voxel_size_world).run();
}

void sign_by_winding_number(FieldBlocks& blocks, const WindingNumber& winding,
                            double voxel_size_world, float background_world,
                            const Progress& progress) {
    ProgressMeter meter(progress, "signs", static_cast<double>(blocks.size()), 16);
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
        FieldBlock& block = blocks[b];
        for (float& value : block.values) value = std::abs(value);
        const SampleBits active = active_bits(block);
        SampleBits negative = winding_signs(block.values, active, voxel_size_world, winding,
                                            block_size * block.coordinate.cast<double>());
        spread(active, negative);
        apply_signs(block, active, negative, background_world);
        meter.add(1);
    });
}

} // namespace isocast
