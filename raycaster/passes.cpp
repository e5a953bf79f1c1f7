// SPDX-License-Identifier: MPL-2.0
#include "raycaster/passes.h"

#include "raycaster/effects/effects.h"
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
        {"solid texture", solid_texture_reads(frame.scene.look.effects.solid_texture),
         FrameImage::SolidTexture, [&frame] { run_solid_texture(frame); }},
        {"curvature colour",
         {FrameImage::Curvature},
         FrameImage::CurvatureColour,
         [&frame] { run_curvature_colour(frame); }},
        {"curvature map",
         {FrameImage::Curvature},
         FrameImage::CurvatureMap,
         [&frame] { run_curvature_map(frame); }},
        {"accessibility",
         {FrameImage::Curvature},
         FrameImage::Accessibility,
         [&frame] { run_accessibility(frame); }},
        {"refraction",
         {FrameImage::Hit, FrameImage::Gradient},
         FrameImage::Refraction,
         [&frame] { run_refraction(frame); }},
        {"reflection",
         {FrameImage::Hit, FrameImage::Gradient},
         FrameImage::Reflection,
         [&frame] { run_reflection(frame); }},
        {"shading", shading_reads(frame.scene.look), FrameImage::Beauty,
         [&frame] { run_shading(frame); }},
    };
}

std::vector<gl::ProgramKey> all_programs() {
    std::vector<gl::ProgramKey> keys = field_programs();
    for (const auto& programs :
         {shading_programs(), solid_texture_programs(), curvature_colour_programs(),
          curvature_map_programs(), accessibility_programs(), refraction_programs(),
          reflection_programs()})
        keys.insert(keys.end(), programs.begin(), programs.end());
    return keys;
}

} // namespace isocast
