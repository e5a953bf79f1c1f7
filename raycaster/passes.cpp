// SPDX-License-Identifier: MPL-2.0
#include "raycaster/passes.h"

#include "raycaster/effects/occlusion.h"
#include "raycaster/effects/shadow.h"
#include "raycaster/field_passes.h"
#include "raycaster/shading.h"

namespace isocast {

std::vector<Pass> declare_passes(FrameContext& frame) {
    const ImageSet bounds = frame.scene.quality.traversal == Traversal::BoundingFaces
                                ? ImageSet{FrameImage::Bounds}
                                : ImageSet{};
    return {
        {"bounds", {}, FrameImage::Bounds, [&frame] { run_bounds(frame); }},
        {"raycast", bounds, FrameImage::Hit, [&frame] { run_raycast(frame); }},
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
        {"shadow map", {}, FrameImage::ShadowMap, [&frame] { run_shadow_map(frame); }},
        {"shadow",
         {FrameImage::Hit, FrameImage::Gradient, FrameImage::ShadowMap},
         FrameImage::Shadow,
         [&frame] { run_shadow(frame); }},
        {"occlusion",
         {FrameImage::Hit, FrameImage::Gradient},
         FrameImage::Occlusion,
         [&frame] { run_occlusion(frame); }},
        {"shading", shading_reads(frame), FrameImage::Beauty, [&frame] { run_shading(frame); }},
    };
}

std::vector<gl::ProgramKey> all_programs() {
    std::vector<gl::ProgramKey> keys = field_programs();
    for (const auto& programs : {shadow_programs(), occlusion_programs(), shading_programs()})
        keys.insert(keys.end(), programs.begin(), programs.end());
    return keys;
}

} // namespace isocast
