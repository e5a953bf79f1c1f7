// Pictures against the double reference casters, pixel by pixel.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/cut.h"
#include "raycaster/reference.h"
#include "stability/cases.h"

namespace isocast::stability {

/// A field whose isosurface is drawn. Space and voxels are the world's: judge_search() takes unit
/// voxels alone.
struct Subject {
    std::shared_ptr<const FieldSource> samples;
    Filter filter = Filter::BSpline;
    double iso = 0;
    StorageOptions storage = {};
    Quality quality = {};
};

struct PictureSize {
    int width = 48;
    int height = 48;
};

/// The hits of one picture.
Image hits_of(Device& device, const Subject& subject, const Camera& camera,
              const PictureSize& size = {});

/// For fields that rays miss easily: values at hits, over what float32 may make of them; see
/// SearchOracle.
///
/// returns  infinite where a ray passes a stretch that is longer than the guarantee and surely
///          inside, stops after it has to, or off its way
Worst judge_search(Device& device, const Subject& subject, const std::vector<Camera>& cameras,
                   const PictureSize& size = {});

/// For fields that rays meet plainly: how far hits lie from the reference's, along the ray
/// [voxels].
///
/// returns  infinite where one hits and the other does not
Worst judge_positions(Device& device, const Subject& subject, const Camera& camera,
                      const PictureSize& size = {});

/// Of primitives: hits off the surface, by their distance from the eye.
///
/// returns  infinite where another primitive shows, or none
Worst judge_primitives(Device& device, Primitives primitives, const Camera& camera,
                       const PictureSize& size = {}, const Cut& cut = {});

/// Infinite unless all bits are the same and something is seen.
Worst same_pictures(const Image& a, const Image& b);

} // namespace isocast::stability
