// Bricks of 32^3 samples with the apron that the tricubic filter needs.
// SPDX-License-Identifier: MPL-2.0
#include "volume/bricks.h"

#include <algorithm>

namespace isocast {

std::vector<Index3> bricks_of(const ActiveBlocks& blocks) {
    std::vector<Index3> bricks;
    for (const Index3& block : blocks.coordinates) {
        const Index3 brick = floor_div(block, brick_size / block_size);
        if (bricks.empty() || bricks.back() != brick) bricks.push_back(brick);
    }
    std::ranges::sort(bricks, zyx_less);
    bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
    return bricks;
}

void cut_brick(const FieldSource& field, const Index3& brick, std::span<float> out) {
    const IndexBox served{brick_size * brick, (brick_size * (brick.array() + 1)).matrix()};
    field.copy_box(dilated(served, filter_support_below, filter_support_above), 0, out);
}

} // namespace isocast
