// The images of a frame as channels of an EXR file (DESIGN section 6).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/camera.h"
#include "raycaster/image.h"

namespace isocast {

/// Images of one frame, of one size. The last two may be empty where no layer needs them.
struct FrameImages {
    Image beauty;         // linear RGB, coverage
    Image hit;            // eye-relative position [world], object (0: none)
    Image gradient;       // world axes; w 1 on a hit
    Image curvature = {}; // k1 >= k2 [1/world], 0; w not 0 on a hit
};

struct ExrLayers {
    bool position = false; // P.X P.Y P.Z: world, 0 on misses
    bool normal = false;   // N.X N.Y N.Z: unit gradient, world axes, 0 on misses
    /// curvature.k1 .k2 .mean .gauss .shapeIndex .curvedness: k1 >= k2 [1/world], their mean,
    /// product, (2/pi) atan((k1 + k2)/(k1 - k2)) in [-1, 1] (0 where both are), and
    /// sqrt((k1^2 + k2^2)/2) [Koenderink & van Doorn 1992]; 0 on misses.
    bool curvature = false;
};

/// Of "P", "N" and "curvature", joined by commas.
/// throws  UsageError that lists the known names
ExrLayers exr_layers_from(std::string_view list);

/// R G B A (half; colour multiplied by coverage, so 0 on misses), Z (distance along the view axis,
/// infinite on misses), the layers asked for, and the attributes worldToCamera (the camera looks
/// down its -z) and worldToNDC (x to the right and y upwards, in -1 … 1 over the picture).
ExrImage exr_image(const FrameImages& frame, const Camera& camera, const ExrLayers& layers);

} // namespace isocast
