// The reference's picture of a view, and how far another is from it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/view/work.h"
#include "raycaster/reference_renderer.h"

namespace isocast::view {

/// One picture on its way; it may take minutes.
struct Comparing {
    Comparing(Scene scene, const Camera& camera, int width, int height, std::function<void()> wake);

    Camera camera;
    int width;
    int height;
    Image picture; // of the thread, until it is done
    Work work;     // the last: it uses the others
};

/// How far a picture is from another of its size, where either shows a surface.
struct Difference {
    Image picture;
    double gain = 1; // of the picture: a power of two that shows the greatest
    double greatest = 0;
    double rms = 0;
};
Difference difference_of(const Image& a, const Image& b);

} // namespace isocast::view
