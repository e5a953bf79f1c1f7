// SPDX-License-Identifier: MPL-2.0
#include "raycaster/passes.h"

#include "raycaster/effects/flow.h"
#include "raycaster/field_passes.h"
#include "raycaster/shading.h"

namespace isocast {

std::vector<Pass> declare_passes(FrameContext& frame) {
    const ImageSet bounds = frame.scene.quality.traversal == Traversal::BoundingFaces
                                ? ImageSet{FrameImage::Bounds}
                                : ImageSet{};
    std::vector<Pass> passes{
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
        {"direction",
         {FrameImage::Hit},
         FrameImage::Direction,
         [&frame] { run_derivatives(frame, FrameImage::Direction, 3); }},
    };
    for (Pass& pass : flow_passes(frame)) passes.push_back(std::move(pass));
    passes.push_back({"shading", shading_reads(frame.scene.look), FrameImage::Beauty,
                      [&frame] { run_shading(frame); }});
    return passes;
}

std::vector<gl::ProgramKey> all_programs() {
    std::vector<gl::ProgramKey> keys = field_programs();
    for (const auto& programs : {flow_programs(), shading_programs()})
        keys.insert(keys.end(), programs.begin(), programs.end());
    return keys;
}

} // namespace isocast
