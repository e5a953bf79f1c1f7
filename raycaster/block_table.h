// The table that rays walk: which blocks are active, and how far the empty ones reach (thesis
// section 6.2).
// SPDX-License-Identifier: MPL-2.0
// twin  shaders/raycast/blocks.glsl
#pragma once

#include "filtering/blocks.h"

#include <cstdint>
#include <vector>

namespace isocast {

// Words of the table. Of a page with active blocks: where its 64 words start; of an active block:
// its number; of an empty page or block: how far the cube of empty pages or blocks around it
// reaches, itself included, and whether the field is negative there.
inline constexpr std::uint32_t word_active = 0x80000000U;
inline constexpr std::uint32_t word_inside = 0x40000000U;
inline constexpr std::uint32_t word_of_page = 0x20000000U;
inline constexpr std::uint32_t word_number = 0x1fffffffU;

/// Two levels: one word for each page of a box of pages, then 64 for each page that has active
/// blocks, by place_in_page.
///
///     pages:  | 2 | 1 |ptr| 1 | 2 |        cubes around empty pages end before pages with blocks
///                       |
///     blocks:     | 1 |#17|#18| 2 | ...    cubes around empty blocks before active blocks
struct BlockTable {
    Index3 first_page = Index3::Zero();
    Index3 pages = Index3::Zero(); // extent; a ring of empty pages surrounds those with blocks
    std::vector<std::uint32_t> words;
    int block_count = 0;

    Index3 lo_index() const { return page_size * first_page; }
};

/// Blocks are numbered in the order of `active`, within a page by place_in_page.
///
/// samples  for the sign where no block is listed
/// throws   ResourceError if the surface spans more than 2^28 pages
BlockTable make_block_table(const FieldSource& samples, const BlockRanges& ranges,
                            const std::vector<ActivePage>& active, float iso);

/// The faces between active blocks and others: number of the block, and 2 axis + 1 for the upper
/// face (thesis section 6.3.1).
std::vector<Eigen::Vector2i> bounding_faces(const BlockTable& table);

} // namespace isocast
