// Which spheres and other primitives can be seen at all: those that others hide need not be drawn.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <cstdint>
#include <span>
#include <vector>

namespace isocast {

/// How a primitive lies in the picture. Pixel (i, j) has its middle at (i + 1/2, j + 1/2), with j
/// upwards or downwards; depths are distances from the eye's plane or anything that grows with
/// them.
struct Footprint {
    // A box that holds all its pixels.
    float x_lo, x_hi;
    float y_lo, y_hi;
    float nearest_depth; // no part of it is nearer
    // A disc of which it covers every pixel, at no more than this depth; none if the radius is 0.
    float disc_x, disc_y, disc_radius;
    float disc_depth;
};

/// A view that footprints are seen in. Eye space: x right, y up, z to the viewer.
struct FootprintView {
    bool is_perspective = true;
    int width = 0;
    int height = 0;
    Eigen::Vector2d middle_pixels = Eigen::Vector2d::Zero(); // what the camera looks at
    /// Pixels of a length of one at depth one, or of parallel rays at any depth.
    double pixels_per_unit = 0;
    double near_depth = 0; // what is nearer is cut away; of parallel rays anything
};

/// Of a sphere in eye space. Across the near plane or the eye's plane: the whole picture, and no
/// disc, since it is cut open.
///
/// source  FORMULAS.md, Quadrics: the box of a sphere; its image is an ellipse with the semi-axis
///         r / sqrt(z^2 - r^2) across the direction to the picture's middle, which is the shorter
///         one
Footprint sphere_footprint(const FootprintView& view, const Vec3d& centre_eye, double radius);

/// A footprint that is not hidden, by its number, and the pixels of the picture in which it is not:
/// from lo up to before hi.
struct VisibleFootprint {
    std::uint32_t number;
    int x_lo, x_hi;
    int y_lo, y_hi;
};

/// The footprints that are not hidden, about from front to back.
///
/// A footprint is hidden where discs that are all nearer than any part of it cover each pixel. Such
/// discs are found tile by tile, front to back, with a mask of the pixels that the last
/// ones cover; so not all that are hidden are found, but none that is seen is missed.
///
/// source    Hasselgren, Andersson and Akenine-Möller 2016, "Masked software occlusion culling"
/// accuracy  boxes are grown and discs shrunk by a 64th of a pixel, and depths are compared with a
///           margin of 2^-16: the splats' own errors are below both
std::vector<VisibleFootprint> visible_footprints(std::span<const Footprint> footprints, int width,
                                                 int height);

} // namespace isocast
