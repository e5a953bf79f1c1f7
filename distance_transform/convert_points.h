// From points to distance field: the narrow band of the meshless transform.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/convert.h"
#include "distance_transform/meshless.h"
#include "distance_transform/point_cloud.h"

namespace isocast {

/// The field of a cloud (Meshless) at every sample where it is at most the half width, on all cores
/// of the current TBB arena; the lattice is convert()'s.
///
/// Near the surface the sign is that of f_near. A sample farther than a spacing from all points
/// takes the side that the winding number of the points tells, if it is above 3/4 or below 1/4 and
/// disagrees (and, where f_near counts nothing, in any case); each point stands for a triangle of
/// its share of the surface. This replaces the sign of f_near in 4.11, which flips behind thin
/// parts.
///
/// options   voxel size, half width and memory count
/// returns   blocks and signs as convert() for an open mesh; samples within two spacings of a point
///           beyond the half width are looked at, so that wider gaps stay open
/// accuracy  of the points' surface, see docs/distance_transform.md; the same for any number of
///           threads
/// throws    InputError for unusable options, ResourceError if the blocks would not fit in memory
ConvertResult convert_points(const CheckedPoints& input, const ConvertOptions& options,
                             const MeshlessOptions& meshless, const Progress& progress = {});

/// What it will take, from the points' shares of the surface.
ConvertEstimate estimate(const CheckedPoints& input, const ConvertOptions& options);

/// The box from which a voxel size follows.
WorldBox bounding_box(const CheckedPoints& input);

} // namespace isocast
