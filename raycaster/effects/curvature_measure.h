// What two principal curvatures say in one number.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/look.h"

namespace isocast {

/// Of k1 >= k2 [1/world]: one of them, their mean, their product, the shape index
/// (2/pi) atan((k1 + k2)/(k1 - k2)) in [-1, 1], which is 1 on a ball and 0 where both vanish, or
/// the curvedness sqrt((k1^2 + k2^2)/2).
///
/// source  Koenderink & van Doorn 1992
/// twin    shaders/shading/curvature_colour/curvature_colour.frag
double curvature_measure(CurvatureMeasure measure, double k1, double k2);

/// "mean curvature" and so on.
std::string_view name_of(CurvatureMeasure measure);

} // namespace isocast
