// Certificates: bounds of a reconstructed function and its derivatives over one block.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/bspline.h"

#include <array>
#include <cstddef>

namespace isocast {

/// Bounds that hold at every point of a block, for the exact function of the control samples.
struct SplineBounds {
    float min;
    float max;
    /// Of |df/dx|, |df/dy|, |df/dz| [1/voxel].
    std::array<float, 3> slope;
    /// Of |d2f/dx2| and so on, in the order xx yy zz xy xz yz [1/voxel^2]. For Kernel::Linear all
    /// are no_bend: its gradient jumps from cell to cell.
    std::array<float, 6> bend;
    /// The greatest |control sample|: what errors of evaluation are proportional to.
    float magnitude;
};

/// Stands for "no bound". A second-order step computed with it is shorter than any other step, and
/// neither it times 0 nor its product with a distance is inf or nan. It exceeds a float16.
inline constexpr float no_bend = 1e30f;

/// Bounds over the block 0 <= x, y, z <= cells, where sample 0 is the block's first.
///
/// control   the sample (-1, -1, -1) of (cells + 3)^3, x contiguous; all finite
/// stride_y, stride_z  samples from one row and one plane to the next
/// cells     at least 4; 8 is fastest
/// accuracy  B-spline: the hull of the control samples and of their differences, rounded outward by
///           at most 2^-22 of slope or bend. Catmull-Rom: at most 2.35 times the greatest first
///           difference and 4.7 times the greatest second; bounds.cpp derives them
/// source    FORMULAS.md, Cubic B-spline and Certified rays
SplineBounds spline_bounds(const float* control, std::ptrdiff_t stride_y, std::ptrdiff_t stride_z,
                           int cells, Kernel kernel);

} // namespace isocast
