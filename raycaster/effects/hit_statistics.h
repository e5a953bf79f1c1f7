// Sizes that a scene and its picture suggest where a look leaves them open.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// Length of the diagonal of the field's extent [world].
double extent_diagonal_world(const FieldSource& field);

/// A curvature that nobody sees: a radius of a hundred objects, which across the object makes a
/// bulge of an 800th of it [1/world].
inline double flat_curvature(const FieldSource& field) {
    return 1e-2 / extent_diagonal_world(field);
}

/// The values of `measure` of (k1, k2) that the shares `low` and `high` of the hits do not exceed.
///
/// measure  may give nothing: that hit does not count, nor do those without a gradient
/// returns  nothing where no hit counts
std::optional<std::array<double, 2>>
curvature_percentiles(FrameContext& frame, double low, double high,
                      const std::function<std::optional<double>(double, double)>& measure);

} // namespace isocast
