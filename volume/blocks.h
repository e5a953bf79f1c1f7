// Which 8^3 blocks can hold a piece of the isosurface (thesis section 6.2.1).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"
#include "volume/progress.h"
#include "volume/sparse_field.h"

namespace isocast {

/// Samples below and above a point's cell that the cubic filter reads: for floor(x) = i it reads
/// i - 1 … i + 2 (thesis eq. 5.1).
inline constexpr int filter_support_below = 1;
inline constexpr int filter_support_above = 2;

/// The active blocks of a field at one iso value.
struct ActiveBlocks {
    /// Block b covers the points 8 b <= p_index < 8 (b + 1). Sorted by z, y, x.
    std::vector<Index3> coordinates;
    /// Box [index] of the cells whose eight corner samples lie on both sides of the iso value, one
    /// that equals it counting as outside; samples as in IndexBox, so the surface lies in
    /// lo … hi - 1. Empty if there is no surface.
    IndexBox surface_box;
};

/// Blocks whose control samples, over the support of the cubic filter, hold the iso value between
/// their least and greatest. By the convex hull of the B-spline the surface lies in no other.
///
/// A plateau at the iso value, where every sample equals it, is active. Only blocks whose support
/// touches an active box of the field are looked at; a field without a band ends at its extent, and
/// its blocks hold samples of it.
ActiveBlocks find_active_blocks(const FieldSource& field, float iso, const Progress& progress = {});

} // namespace isocast
