// The oracle: every triangle against every point, in double, nothing clever.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

namespace isocast {

/// Least distance from `p_world` to any triangle [world]; unsigned.
double brute_force_distance(const Mesh& mesh, const Vec3d& p_world);

/// Generalised winding number of the mesh about `p_world`: 1 inside, 0 outside a closed mesh.
/// source  van Oosterom & Strackee 1983, the solid angle of a triangle
double brute_force_winding_number(const Mesh& mesh, const Vec3d& p_world);

} // namespace isocast
