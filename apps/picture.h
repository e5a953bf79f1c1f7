// Pictures of any size: drawn in tiles, with many samples a pixel, and given row by row.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/exr_layers.h"
#include "apps/stereo.h"
#include "raycaster/renderer.h"

namespace isocast {

struct PictureRequest {
    int width = 0;
    int height = 0;
    bool has_beauty = true;
    std::vector<FrameImage> others; // from rays through the pixels' middles
    int samples = 1;                // of the beauty, a pixel
    PixelFilter pixel_filter = PixelFilter::Box;
    int tile_pixels = 0; // 0: tiles only if the picture is large
    int repeat = 1;      // each frame is drawn so often, for times
};

/// What draws the parts of a picture.
struct PictureSource {
    int greatest_extent = 0; // the longest side of a part
    int reach = 0;           // reach_pixels()
    /// Renderer::draw.
    std::function<FrameReport(const Camera&, int width, int height, const ImageSet&,
                              const PicturePart&)>
        draw;
    std::function<Image(FrameImage)> read; // of what was drawn last
};
PictureSource source_of(Renderer& renderer); // which must outlive it

/// Where in a pixel its samples lie [pixels from its middle]: Hammersley's points, no two of which
/// share a row or column, moved so that the filter is even weights. Multiples of 1/128.
///
/// samples  a power of two up to 64
/// source   point i of n: ((i + 1/2)/n, the bits of i in reverse, + 1/2n); a tent by the inverse of
///          its distribution function, along each axis
std::vector<Eigen::Vector2d> sample_shifts(int samples, PixelFilter filter);

/// How far around a pixel effects look at others, or at those of its quad.
int reach_pixels(const Look& look);

/// The part with so many pixels around it, in whole quads of the picture's pixels, which count from
/// its bottom left corner.
PicturePart with_reach(const PicturePart& part, int reach, int width, int height);

/// The parts in which a picture is drawn, row by row.
///
/// edge   of a part; 0: one part unless the picture is large
/// limit  the longest side of one
std::vector<PicturePart> parts_of(int width, int height, int edge, int limit);

/// Draws the source's scene. Pixels are bit by bit the same for any tiles.
///
/// views    windows of the request's size
/// write    takes the next rows of each view, from the top; images that were not asked for are
/// empty returns  what passes cost in all; bytes are those held at a time throws   as the source's
/// draw
FrameReport draw_picture(const PictureSource& source, const std::vector<PictureView>& views,
                         const PictureRequest& request,
                         const std::function<void(const std::vector<FrameImages>&)>& write,
                         const Progress& progress = {});

} // namespace isocast
