// Distances beyond a band, from those in it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/dense_field.h"
#include "volume/progress.h"
#include "volume/sparse_field.h"

namespace isocast {

/// A full grid over `box` that continues the band of a signed distance field by fast sweeping.
///
/// accuracy  the band's own values within it; beyond, first order in the voxel, and the distance to
///           the band's border rather than to the surface
/// source    Zhao 2005, by OpenVDB's tools::maskSdf
/// throws    InputError for a field without signs or an empty box
DenseField extend_by_sweeping(const SparseField& band, const IndexBox& box);

} // namespace isocast
