// Signs that distance cannot have, since it changes by no more than one moves.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mended_signs.h"

#include "distance_transform/block_signs.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace isocast {

namespace {

/// From 1/2: three times what the number may be off by (WindingNumber).
constexpr double least_decision = 0.15;

class Neighbourhood {
public:
    Neighbourhood(const FieldBlocks& blocks, const FieldBlock& middle) : middle_(middle) {
        for (int side = 0; side < 6; ++side) {
            const Index3 coordinate = middle.coordinate + direction(side);
            const auto found =
                std::ranges::lower_bound(blocks, coordinate, zyx_less, &FieldBlock::coordinate);
            const bool is_there = found != blocks.end() && found->coordinate == coordinate;
            beside_[side] = is_there ? &*found : nullptr;
        }
    }

    /// Of the six neighbours of sample i: those that contradict it, and the others that are there.
    struct Votes {
        int against = 0;
        int with = 0;
    };
    Votes votes(int i, float voxel_world) const {
        const float value = middle_.values[i];
        Votes votes;
        for (int side = 0; side < 6; ++side) {
            const int shift = 3 * (side / 2);
            const int place = i >> shift & (block_size - 1);
            const int next = place + (side % 2 == 0 ? -1 : 1);
            const FieldBlock* block = next < 0 || next == block_size ? beside_[side] : &middle_;
            if (block == nullptr) continue;
            const float other =
                block->values[i + (((next & (block_size - 1)) - place) * (1 << shift))];
            const bool is_against = std::signbit(value) != std::signbit(other) &&
                                    std::abs(value) + std::abs(other) > 2 * voxel_world;
            ++(is_against ? votes.against : votes.with);
        }
        return votes;
    }

private:
    static Index3 direction(int side) {
        Index3 result = Index3::Zero();
        result[side / 2] = side % 2 == 0 ? -1 : 1;
        return result;
    }

    const FieldBlock& middle_;
    std::array<const FieldBlock*, 6> beside_;
};

} // namespace

std::int64_t mend_signs(FieldBlocks& blocks, float voxel_world,
                        const std::function<double(const Vec3d&)>& winding_at) {
    std::vector<std::vector<int>> wrong(blocks.size());
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
        const Neighbourhood neighbourhood(blocks, blocks[b]);
        for (int i = 0; i < samples_per_block; ++i) {
            if (!blocks[b].active[i]) continue;
            const auto votes = neighbourhood.votes(i, voxel_world);
            if (votes.against == 0) continue;
            const Index3 p = block_size * blocks[b].coordinate + sample_of(i);
            const double winding = winding_at(p.cast<double>());
            const bool is_wrong = std::abs(winding - 0.5) > least_decision
                                      ? (winding > 0.5) != std::signbit(blocks[b].values[i])
                                      : votes.against > votes.with;
            if (is_wrong) wrong[b].push_back(i);
        }
    });
    std::int64_t count = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        for (const int i : wrong[b]) blocks[b].values[i] = -blocks[b].values[i];
        count += static_cast<std::int64_t>(wrong[b].size());
    }
    return count;
}

} // namespace isocast
