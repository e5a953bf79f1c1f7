// A narrow band of an octree's surface on one lattice: what level sets in files are.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/hashed_octree.h"
#include "volume/progress.h"
#include "volume/sparse_field.h"

#include <memory>

namespace isocast {

/// The samples at the corners of the cells of level `lattice`, of size 2^lattice finest cells.
///
/// space              of the finest cells
/// half_width_voxels  of the band, in cells of the lattice; at least 1
/// throws             as OctreeField
SparseField band_of_octree(std::shared_ptr<const HashedOctree> tree, const GridSpace& space,
                           int lattice, double half_width_voxels, const Progress& progress = {});

} // namespace isocast
