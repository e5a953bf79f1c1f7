// Which 8^3 blocks can hold a piece of the isosurface, at any iso value (thesis section 6.2.1).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/bspline.h"
#include "volume/field_source.h"
#include "volume/progress.h"
#include "volume/sparse_field.h"

#include <array>
#include <cstdint>
#include <vector>

namespace isocast {

/// Samples below and above a point's cell that the cubic filter reads: for floor(x) = i it reads
/// i - 1 … i + 2 (thesis eq. 5.1).
inline constexpr int filter_support_below = 1;
inline constexpr int filter_support_above = 2;

/// Blocks along an edge of a page: blocks are looked at, and listed for the GPU, by 4^3.
inline constexpr int page_blocks = 4;
inline constexpr int blocks_per_page = page_blocks * page_blocks * page_blocks;
/// Cells along an edge of a page.
inline constexpr int page_size = page_blocks * block_size;

/// The place of a block in its page: x + 4 y + 16 z.
inline int place_in_page(int x, int y, int z) {
    return x + page_blocks * (y + page_blocks * z);
}

inline Index3 block_in_page(int place) {
    return {place % page_blocks, place / page_blocks % page_blocks,
            place / (page_blocks * page_blocks)};
}

/// 4^3 blocks and the range of the reconstructed function in each.
struct BlockPage {
    Index3 coordinate = Index3::Zero(); // it covers the points 32 c <= p_index < 32 (c + 1)
    std::uint64_t blocks = 0;           // by place_in_page: those that hold samples of the field
    ValueRange range{};                 // of those
    ValueRange samples{};               // of all control samples that the page's blocks read
    std::array<ValueRange, blocks_per_page> ranges{};
};

/// The ranges of all blocks of a field.
///
/// The surface f = iso lies in no block whose range does not hold iso. Only blocks whose support
/// touches an active box of the field are listed; a field without a band ends at its extent, and
/// its blocks hold samples of it.
struct BlockRanges {
    std::vector<BlockPage> pages; // sorted by z, y, x
};

/// The pages alone, without ranges.
BlockRanges find_blocks(const FieldSource& control);

/// control  the field of the kernel's control samples
/// source   filtering/certificate.h: ranges_of_page
BlockRanges find_block_ranges(const FieldSource& control, Kernel kernel,
                              const Progress& progress = {});

/// A block's range, widened by 1e-5 of itself, so that a hit which rounding moved over a block's
/// face still finds its samples there.
inline ValueRange widened(const ValueRange& range) {
    const float margin = 1e-5F * (range.max - range.min);
    return {range.min - margin, range.max + margin};
}

/// Whether a block of this range is active: whether its widened range meets iso ± value_error.
bool is_active(const ValueRange& range, float iso, float value_error);

/// A page and its active blocks.
struct ActivePage {
    std::size_t page = 0;     // in BlockRanges::pages
    std::uint64_t blocks = 0; // by place_in_page
};

/// The pages with active blocks, in the order of `ranges`. A plateau at the iso value, where every
/// sample equals it, is active. Looks at all ranges; ActiveSet follows an iso value that moves.
///
/// value_error  by which values may differ from the samples', as those that are stored do
std::vector<ActivePage> active_pages(const BlockRanges& ranges, float iso, float value_error = 0);

/// The active blocks of a field at one iso value.
struct ActiveBlocks {
    /// Block b covers the points 8 b <= p_index < 8 (b + 1). Sorted by z, y, x.
    std::vector<Index3> coordinates;
    /// Box [index] of the cells whose eight corner samples lie on both sides of the iso value, one
    /// that equals it counting as outside; samples as in IndexBox, so the surface lies in
    /// lo ... hi - 1. Empty if there is no surface.
    IndexBox surface_box;
};

/// active_pages of find_block_ranges, block by block.
ActiveBlocks find_active_blocks(const FieldSource& control, Kernel kernel, float iso,
                                const Progress& progress = {});

/// ActiveBlocks::surface_box alone. Looks at the samples of the active blocks once more, from the
/// outermost inwards, as far as they can still widen the box: a few of a closed surface's.
IndexBox find_surface_box(const FieldSource& control, const BlockRanges& ranges,
                          const std::vector<ActivePage>& active, float iso);

} // namespace isocast
