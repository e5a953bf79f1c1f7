// Sizes that a scene and its picture suggest where a look leaves them open.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// Of FrameImage::Curvature: the gradient vanishes there.
inline constexpr float no_gradient = 2;

/// A curvature that nobody sees: a radius of a hundred objects, which across the object makes a
/// bulge of an 800th of it [1/world].
inline double flat_curvature(const FrameContext& frame) {
    return 1e-2 / extent_diagonal_world(frame);
}

/// Statistics are those of the whole picture in so many pixels along its longer side at most, so
/// that they do not depend on the part and the samples that are drawn.
inline constexpr int overview_pixels = 256;

/// The least value that a `share` of the hits do not exceed, in the first picture since load that
/// has any; nothing in a picture without hits.
///
/// name     of what is found; says all that `share` and `measure` depend on
/// image    an image of the frame that has been drawn, and follows from the field's derivatives
/// measure  of a pixel's four floats; may give nothing: that hit does not count
std::optional<double> percentile(FrameContext& frame, const std::string& name, FrameImage image,
                                 double share,
                                 const std::function<std::optional<double>(const float*)>& measure);

} // namespace isocast
