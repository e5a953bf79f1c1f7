// Which images a new look makes anew.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame_plan.h"
#include "raycaster/look.h"

namespace isocast {

/// Those that differ for the same hits, but for the shadow map, and for images that are made of
/// these. A strength is a matter of shading alone.
ImageSet images_changed(const Look& before, const Look& after);

} // namespace isocast
