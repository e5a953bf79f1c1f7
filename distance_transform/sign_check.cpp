// Whether the signs of a band fit together, and what to do if not.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/sign_check.h"

#include "distance_transform/block_transform.h"
#include "distance_transform/progress_meter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace isocast {

namespace {

class SignCheck {
public:
    SignCheck(const std::vector<FieldBlock>& blocks, double voxel_size)
        : blocks_(blocks), least_sum_(voxel_size * (1 + 1e-5)) {} // 1e-5: rounding to float

    bool run() const {
        std::atomic<bool> is_consistent = true;
        tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t b) {
            if (is_consistent && !(fits_neighbours(blocks_[b]) && fits_row(b)))
                is_consistent = false;
        });
        return is_consistent;
    }

private:
    bool disagree(float a, float b) const {
        return (a < 0) != (b < 0) && std::abs(a) + std::abs(b) > least_sum_;
    }

    /// Each sample with its neighbours at higher x, y and z, in this block or the next.
    bool fits_neighbours(const FieldBlock& block) const {
        for (int axis = 0; axis < 3; ++axis) {
            const Index3 step = Index3::Unit(axis);
            const auto next = std::ranges::lower_bound(blocks_, Index3(block.coordinate + step),
                                                       zyx_less, &FieldBlock::coordinate);
            const bool has_next =
                next != blocks_.end() && next->coordinate == block.coordinate + step;
            const int stride = axis == 0 ? 1 : axis == 1 ? block_size : block_size * block_size;
            for (int i = 0; i < samples_per_block; ++i) {
                const bool is_last = i / stride % block_size == block_size - 1;
                if (is_last && !has_next) continue;
                const float neighbour = is_last ? next->values[i - (block_size - 1) * stride]
                                                : block.values[i + stride];
                if (disagree(block.values[i], neighbour)) return false;
            }
        }
        return true;
    }

    /// What the field's rule gives beyond this block against the next stored one, or + at the end.
    bool fits_row(std::size_t b) const {
        const Index3& here = blocks_[b].coordinate;
        const bool is_row_end =
            b + 1 == blocks_.size() || blocks_[b + 1].coordinate.tail<2>() != here.tail<2>();
        const bool is_inside = is_inside_beyond(blocks_[b]);
        if (is_row_end) return !is_inside;
        const FieldBlock& next = blocks_[b + 1];
        return next.coordinate.x() == here.x() + 1 || is_inside == (next.values[0] < 0);
    }

    const std::vector<FieldBlock>& blocks_;
    double least_sum_;
};

} // namespace

bool signs_are_consistent(const std::vector<FieldBlock>& blocks, double voxel_size_world) {
    return SignCheck(blocks, voxel_size_world).run();
}

void sign_by_winding_number(std::vector<FieldBlock>& blocks, const WindingNumber& winding,
                            float background_world, const Progress& progress) {
    ProgressMeter meter(progress, "signs", static_cast<double>(blocks.size()), 16);
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
        FieldBlock& block = blocks[b];
        for (int i = 0; i < samples_per_block; ++i) {
            if (!block.active[i]) continue;
            const Index3 sample =
                block_size * block.coordinate +
                Index3(i % block_size, i / block_size % block_size, i / (block_size * block_size));
            const float distance = std::abs(block.values[i]);
            block.values[i] = winding.is_inside(sample.cast<double>()) ? -distance : distance;
        }
        spread_signs(block, background_world);
        meter.add(1);
    });
}

} // namespace isocast
