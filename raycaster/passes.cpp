// SPDX-License-Identifier: MPL-2.0
#include "raycaster/passes.h"

#include "raycaster/composition.h"
#include "raycaster/field_passes.h"
#include "raycaster/shading.h"

namespace isocast {

std::vector<Pass> declare_passes(FrameContext& frame) {
    const ImageSet bounds = frame.scene.quality.traversal == Traversal::BoundingFaces
                                ? ImageSet{FrameImage::Bounds}
                                : ImageSet{};
    return {
        {"bounds", {}, FrameImage::Bounds, [&frame] { run_bounds(frame); }},
        {"raycast", bounds, FrameImage::Hit,
         [&frame] {
             if (is_composed(frame.scene))
                 run_composition(frame);
             else
                 run_raycast(frame);
         }},
        {"gradient",
         {FrameImage::Hit},
         FrameImage::Gradient,
         [&frame] {
             if (!frame.has_fused_gradient) run_derivatives(frame, FrameImage::Gradient, 1);
         }},
        {"curvature",
         {FrameImage::Hit},
         FrameImage::Curvature,
         [&frame] { run_derivatives(frame, FrameImage::Curvature, 2); }},
        {"shading", shading_reads(frame.scene.look), FrameImage::Beauty,
         [&frame] { run_shading(frame); }},
    };
}

std::vector<gl::ProgramKey> all_programs() {
    std::vector<gl::ProgramKey> keys = field_programs();
    for (const gl::ProgramKey& key : composition_programs()) keys.push_back(key);
    for (const gl::ProgramKey& key : shading_programs()) keys.push_back(key);
    return keys;
}

} // namespace isocast
