// The images of a frame as channels of an EXR file (DESIGN section 6).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/camera.h"
#include "raycaster/frame_plan.h"
#include "raycaster/image.h"

#include <optional>

namespace isocast {

/// Images of one frame, or of rows of it, as FrameImage says; empty where no layer needs them.
/// Colours are multiplied by coverage.
using FrameImages = std::map<FrameImage, Image>;

struct ExrLayers {
    bool position = false; // P.X P.Y P.Z: world, 0 on misses
    bool normal = false;   // N.X N.Y N.Z: unit gradient, world axes, 0 on misses
    /// curvature.k1 .k2 .mean .gauss .shapeIndex .curvedness: k1 >= k2 [1/world], their mean,
    /// product, (2/pi) atan((k1 + k2)/(k1 - k2)) in [-1, 1] (0 where both are), and
    /// sqrt((k1^2 + k2^2)/2) [Koenderink & van Doorn 1992]; 0 on misses.
    ///
    /// curvature.flag: 0 on misses, 1 on regular points, 2 where the gradient vanishes, 3 at
    /// umbilics.
    bool curvature = false;
    bool directions = false; // T1.X … T2.Z: unit, of k1 and k2, T2 = N x T1; 0 on misses
    bool occlusion = false;  // AO.Y: share of the sky that is seen; 0 on misses
    bool shadow = false;     // shadow.Y: share of the light that is seen; 0 on misses
    bool id = false;         // id: number of the object, from 1; 0 on misses
    bool steps = false;      // debug.steps: looks at the field, of hits and misses
};

/// What exr_layers_from understands.
inline constexpr std::string_view exr_layer_names = "P, N, curvature, T, AO, shadow, id, steps";

/// Of exr_layer_names, joined by commas.
/// throws  UsageError that lists them
ExrLayers exr_layers_from(std::string_view list);
/// The other way.
std::vector<std::string> names_of(const ExrLayers& layers);

/// The images, beside the beauty, that layers are made of.
std::vector<FrameImage> images_of(const ExrLayers& layers);

/// If there is a beauty R G B A (half; 0 on misses); Z (distance along the view axis, infinite on
/// misses), the layers asked for, and the attributes worldToCamera (the camera looks down its -z)
/// and worldToNDC (x to the right and y upwards, in -1 … 1 over the picture).
///
/// aspect    of the picture, where `frame` shows some rows of it
/// off_axis  as PictureView has it
ExrImage exr_image(const FrameImages& frame, const Camera& camera, const ExrLayers& layers,
                   const std::optional<double>& aspect = {}, double off_axis = 0);

} // namespace isocast
