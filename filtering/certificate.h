// What certifies a ray's steps through a block: where the surface can be in it, and how steep and
// how bent the reconstructed function can be.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/blocks.h"
#include "filtering/bspline.h"
#include "volume/field_source.h"
#include "volume/sparse_field.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace isocast {

/// Edge of the parts of a block, in cells.
inline constexpr int part_size = 2;
/// Parts along a block's edge.
inline constexpr int block_parts = block_size / part_size;

/// Holds at every point of a block, for the exact function of the control samples.
struct Certificate {
    /// Of |gradient| [1/voxel].
    float slope = 0;
    /// Of the second derivative along any direction [1/voxel^2], in the near cells: those that hold
    /// a value no farther from zero than `near`. bounds.h: no_bend if there is no bound.
    float bend = 0;
    float near = 0;
    /// The parts of 2^3 cells that can hold the surface f = 0, or come within 1e-4 voxel of it, by
    /// x + 4 y + 16 z.
    std::uint64_t parts = 0;
};

/// The range of the block's values.
///
/// control   the sample below the block's first one along each axis; 11^3 samples are read
/// returns   B-spline: the hull of the Bezier points of its cells, which lies within the hull of
///           the control samples; others as spline_bounds
/// accuracy  B-spline: rounded outward by 2^-20 of the greatest |control sample|
ValueRange range_of_block(const float* control, std::ptrdiff_t stride_y, std::ptrdiff_t stride_z,
                          Kernel kernel);

/// The same of all blocks of a page, by place_in_page; a fifth faster.
///
/// control  the sample below the page's first one along each axis; 35^3 samples are read
std::array<ValueRange, blocks_per_page> ranges_of_page(const float* control,
                                                       std::ptrdiff_t stride_y,
                                                       std::ptrdiff_t stride_z, Kernel kernel);

/// `near` becomes what the steepest function falls in one voxel, or the greatest float where
/// leaving cells out gains little.
///
/// control   as range_of_block; the surface is where the function is zero
/// accuracy  rounded outward by 2^-20 of themselves; the bend by 2^-21 of the greatest first
///           difference too, and the values that parts and near cells hold by 2^-20 of the greatest
///           |control sample|. Differences below 1e-18, whose squares underflow, do not count
/// source    docs/raycasting.md, where it is proved that cells that are not near do not matter
Certificate certify_block(const float* control, std::ptrdiff_t stride_y, std::ptrdiff_t stride_z,
                          Kernel kernel);

} // namespace isocast
