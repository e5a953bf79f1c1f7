// SLIM surfaces in three passes: where their nearest sheet lies, its pieces blended, and then as
// one splat among the others (Stoll et al. 2006, 5.1.1).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"
#include "raycaster/splat_passes.h"

namespace isocast {

/// Whether the scene has any, be they seen or not.
bool has_slims(const FrameContext& frame);

/// FrameImage::SlimNearest.
void run_slim_nearest(FrameContext& frame);
/// FrameImage::SlimHit.
void run_slim_hits(FrameContext& frame);
/// For shaders that read hits, at 1 and 15.
void bind_slim_hits(const FrameContext& frame);
/// What they show, among other splats: a number, or as FrameImage::SplatSurface, by depth.
///
/// output  Number or Surface
void draw_slim_hits(const FrameContext& frame, SplatOutput output, double depth_unit);

/// Blended Hessians by the length of the gradient, for one pass.
struct SlimBends {
    explicit SlimBends(FrameContext& frame);
    std::array<gl::Texture, 2> textures; // sums by weight: xx xy xz yy, yz zz - weight
};

/// Every program that these can ask for.
std::vector<gl::ProgramKey> slim_programs();

} // namespace isocast
