// The built-in picture that shows what shape a surface has.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

namespace isocast {

/// Linear RGB for principal curvatures in units of the range, in either order: grey where both
/// vanish, then by shape blue cups, cyan valleys, green saddles, yellow ridges, red caps, after the
/// idea of Kindlmann et al. 2003.
Vec3d builtin_curvature_map(double k1, double k2);

} // namespace isocast
