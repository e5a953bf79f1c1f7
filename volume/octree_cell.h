// Places and sizes of an octree's cells.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <cstdint>

namespace isocast {

/// Depths that an octree may have: cells of 2^0 … 2^20 finest cells.
inline constexpr int greatest_octree_depth = 20;

/// A cube of 2^level finest cells an edge; its lowest corner, a multiple of that, is `position`.
struct OctreeCell {
    Index3 position = Index3::Zero();
    int level = 0;

    int size() const { return 1 << level; }
    bool operator==(const OctreeCell&) const = default;
};

/// The cell of a level that holds a position.
inline OctreeCell cell_around(const Index3& position, int level) {
    return {position.unaryExpr([=](int i) { return i >> level << level; }), level};
}
inline OctreeCell parent_of(const OctreeCell& cell) {
    return cell_around(cell.position, cell.level + 1);
}
/// At the upper half of x if bit 0 of i is set, of y if bit 1, of z if bit 2.
inline OctreeCell child_of(const OctreeCell& cell, int i) {
    return {cell.position + Index3(i & 1, i >> 1 & 1, i >> 2) * (cell.size() / 2), cell.level - 1};
}

// What follows works on scalars: vectors would wait until their parts are stored.

/// Which child of its parent is the cell of a level that holds a position.
inline unsigned child_index(const Index3& position, int level) {
    const auto bit = [&](int axis) { return static_cast<unsigned>(position[axis]) >> level & 1; };
    return bit(0) | bit(1) << 1 | bit(2) << 2;
}

/// A number for the cell of a level that holds a position, never 0. Cells of level 0 have none:
/// they are not divided. 5 bits for the level, 19 for each of x, y, z.
inline std::uint64_t key_of(const Index3& position, int level) {
    static_assert(greatest_octree_depth <= 20);
    const auto field = [&](int axis) {
        return static_cast<std::uint64_t>(static_cast<unsigned>(position[axis]) >> level);
    };
    return static_cast<std::uint64_t>(level) << 57 | field(2) << 38 | field(1) << 19 | field(0);
}
inline std::uint64_t key_of(const OctreeCell& cell) {
    return key_of(cell.position, cell.level);
}

} // namespace isocast
