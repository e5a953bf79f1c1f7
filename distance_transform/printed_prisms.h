// The thesis's prism scan conversion as printed: one frustum per triangle (4.2.3).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/lattice.h"
#include "distance_transform/prism.h"
#include "distance_transform/reference_band.h"
#include "volume/progress.h"

namespace isocast {

/// Least distance at each sample to the triangles whose prisms hold it, with the sign of the
/// closest feature's pseudonormal, on all cores of the current TBB arena.
///
/// memory_bytes  what pairs of prism and block, and the blocks, may take
/// returns   where no prism holds a sample of the band it is missing; where only prisms of other
///           triangles do, its distance is too large. Shown by band_errors(), not mended.
/// throws    InputError as one_rings(), or if the mesh is not closed; ResourceError beyond
///           memory_bytes
/// source    Sigg 2006, section 4.2.3; the sign is Bærentzen & Aanæs 2005 instead of listing 4.1's,
///           which is wrong where triangles tie
ReferenceBand scan_convert_prisms(const LatticeMesh& lattice, double half_width_voxels, Gaps gaps,
                                  double memory_bytes, const Progress& progress = {});

} // namespace isocast
