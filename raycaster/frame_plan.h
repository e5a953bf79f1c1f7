// Which passes run: one backward walk from the requested images decides.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <bitset>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace isocast {

/// The images of a frame. A changed image gets a new name, so each has one writer.
enum class FrameImage {
    Bounds, // where rays first and last meet the faces around active blocks: t, -t [voxels]
    Splat,  // number of the first primitive + 1, as this camera's splats are numbered; 0: none
    SplatSurface, // integers: number of its colour + 1, with bit 31 of the half at b of a stick, 0:
                  // none; its normal, view space, as shaders/common/octahedral.glsl
    SlimNearest,  // of SLIM surfaces: where the sheet that shows surely lies behind, by depth;
                  // number of its colour + 1, below 0 if it shows its inside, 0: none
    SlimHit,      // sums by weight over its pieces: shaders/quadrics/slim_blend.glsl
    Hit,          // first hit: eye-relative position [world], object
    Steps,        // how often the ray's search looked at the field
    Gradient,  // gradient of the field at the hit [1/world * world], world axes; of primitives the
               // unit normal, then how wide they are, by 16 pixels and 1 at most; 1 for fields
    Curvature, // principal curvatures k1 >= k2 [1/world], 0; 1, or 2 where the gradient vanishes,
               // 3 at umbilics
    ViewCurvature,     // normal curvature in the direction of the ray [1/world]
    FlowLineCurvature, // how fast the gradient turns along itself [1/world]
    Direction, // of k1, unit, world axes (that of k2 is normal x this); how far k1 and k2 differ,
               // by |k1| + |k2|: 0 at umbilics and where the gradient vanishes
    ShadowMap, // how far below the light's plane it sees the surface [texels]
    FlowNoise, // a noise in space at the hit: mean 0, variance 1
    OutlineSource, // unit normal, nearness, affine over the picture of a plane; 0 beside hits
    // What effects make. Layers: linear RGB, coverage.
    SplatColour, // of the primitive that is hit
    SolidTexture,
    CurvatureColour,
    CurvatureMap,
    Uncertainty,
    Flow, // a factor, 1 on average
    Accessibility,
    Occlusion, // share of the sky that is seen
    Shadow,    // share of the light that is seen, samples taken
    Refraction,
    Reflection,
    Ridges,
    Contours,
    Outlines,
    Slice,
    Beauty, // shaded colour, linear; coverage
};
inline constexpr int frame_image_count = 31;

std::string_view name_of(FrameImage image);

/// A set of frame images.
class ImageSet {
public:
    ImageSet() = default;
    ImageSet(std::initializer_list<FrameImage> images) {
        for (const FrameImage image : images) insert(image);
    }
    void insert(FrameImage image) { bits_.set(static_cast<std::size_t>(image)); }
    bool contains(FrameImage image) const { return bits_.test(static_cast<std::size_t>(image)); }
    void insert(const ImageSet& other) { bits_ |= other.bits_; }
    void erase(FrameImage image) { bits_.reset(static_cast<std::size_t>(image)); }
    void erase(const ImageSet& other) { bits_ &= ~other.bits_; }
    /// Whether all of `other` are in it.
    bool contains(const ImageSet& other) const { return (other.bits_ & ~bits_).none(); }

private:
    std::bitset<frame_image_count> bits_;
};

/// One step of the frame: the images it reads, the one image it writes, and the GL work.
struct Pass {
    std::string_view name;
    ImageSet reads;
    FrameImage writes;
    std::function<void()> run;
};

/// The passes that `wanted` depends on, in order.
/// throws  std::logic_error, naming the pass, if one reads what no pass before it writes, or if a
///         wanted image has no writer
std::vector<Pass> live_passes(const std::vector<Pass>& declared, const ImageSet& wanted);

/// The live passes that read what `pass` writes, or "output" if it is wanted itself; for reports.
std::string asked_by(const Pass& pass, const std::vector<Pass>& live, const ImageSet& wanted);

} // namespace isocast
