// Robust ranges of what a picture shows.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// The least value that a `share` of the hits do not exceed; nothing in a picture without hits.
///
/// image    an image of the frame that has been drawn, as Hit has
/// measure  of a pixel's four floats
std::optional<double> percentile(FrameContext& frame, FrameImage image, double share,
                                 const std::function<double(const float*)>& measure);

} // namespace isocast
