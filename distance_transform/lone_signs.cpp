// Signs that the distance's slope rules out.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/lone_signs.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace isocast {

namespace {

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

    bool contradicts(int i, float voxel_world) const {
        const float value = middle_.values[i];
        int votes = 0;
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
            votes += is_against ? 1 : -1;
        }
        return votes > 0;
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

std::int64_t turn_lone_signs(FieldBlocks& blocks, float voxel_world) {
    std::vector<std::vector<int>> lone(blocks.size());
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
        const Neighbourhood neighbourhood(blocks, blocks[b]);
        for (int i = 0; i < samples_per_block; ++i)
            if (blocks[b].active[i] && neighbourhood.contradicts(i, voxel_world))
                lone[b].push_back(i);
    });
    std::int64_t count = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        for (const int i : lone[b]) blocks[b].values[i] = -blocks[b].values[i];
        count += static_cast<std::int64_t>(lone[b].size());
    }
    return count;
}

} // namespace isocast
