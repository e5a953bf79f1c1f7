// Which blocks are active, kept while the iso value moves (thesis section 6.2.1).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/blocks.h"

#include <cstdint>
#include <vector>

namespace isocast {

/// The blocks that an isosurface came into and those that it left, in no order.
struct ActiveChange {
    struct Block {
        std::uint32_t page;  // in BlockRanges::pages
        std::uint32_t place; // place_in_page
        auto operator<=>(const Block&) const = default;
    };
    std::vector<Block> came;
    std::vector<Block> went;
};

/// The answer of active_pages at one iso value, and what changes in it at the next.
///
/// The ends of all ranges are sorted. A block becomes active, or ceases to be, only if the iso
/// value passes an end of its range; so a move looks at the ends between the two values and at no
/// others:
///
///     lower ends  --|--|---|||--|-----|----|-->      blocks of these come, if not already passed
///                          a ~~~~~~> b
///     upper ends  ----|-----|--|-||-----|--|-->      blocks of these go
///
/// source  thesis section 6.2.1 asks for a range query; Cignoni et al. 1998 (CSS98 there) answer
///         one at any value by an interval tree, this the difference of two
class ActiveSet {
public:
    /// ranges  must outlive this; fewer than 2^26 pages. 16 bytes a block are kept
    ActiveSet(const BlockRanges& ranges, float iso, float value_error = 0);

    /// Time is proportional to the ends of ranges that are passed.
    ActiveChange move_to(float iso, float value_error = 0);

    /// Equals active_pages at the last iso value. Time is proportional to the pages.
    std::vector<ActivePage> pages() const;

private:
    struct End {
        float value;         // of a widened range
        std::uint32_t block; // page * blocks_per_page + place
    };

    const BlockRanges* ranges_;
    std::vector<End> lower_; // sorted by value
    std::vector<End> upper_;
    std::vector<std::uint64_t> active_; // blocks of each page
    float iso_;
    float value_error_;
};

} // namespace isocast
