// Stereo pairs: what each eye sees of a scene, by parallel frusta.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/scene_file.h"

namespace isocast {

/// A window of a picture, of its height, that need not be around the picture's middle.
struct PictureView {
    std::string name = {}; // "left" or "right" of a pair
    Camera camera;         // looks at the picture's middle
    int picture_width = 0;
    double first_pixel = 0; // of the window, from the picture's left; a multiple of 1/128

    /// How far to the right of the window's middle the camera looks, by half the window's width.
    double off_axis(int width) const { return (picture_width - width - 2 * first_pixel) / width; }
};

/// One view; two, the left eye's first, of a camera with `stereo`.
///
/// Both eyes look along parallel axes, half the separation to each side of the camera, through
/// windows in the plane through the target: what lies in it is at the same pixel of both pictures,
/// within 1/256 of a pixel, which windows are rounded to. Nothing is turned, so that no point is
/// higher in one picture than in the other.
std::vector<PictureView> views_of(const SceneFile& scene, const Camera& camera);

} // namespace isocast
