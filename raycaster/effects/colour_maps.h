// From a number to a colour.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/look.h"

namespace isocast {

/// Linear RGB at t in [0, 1].
///
/// accuracy  viridis: 18 of its 256 published colours, between them linear in sRGB, off by 0.02
///           there at most (blue, near the end)
/// source    viridis: S. van der Walt, N. Smith, E. Firing, bids.github.io/colormap (CC0).
///           Cool-warm: Moreland, "Diverging Color Maps for Scientific Visualization", 2009, by its
///           Msh coordinates
Vec3d colour_of(ColourMap map, double t);

/// Of a measure: viridis where it has one sign.
inline ColourMap default_colour_map(CurvatureMeasure measure) {
    return measure == CurvatureMeasure::Curvedness ? ColourMap::Viridis : ColourMap::CoolWarm;
}

} // namespace isocast
