// SPDX-License-Identifier: MPL-2.0
#include "raycaster/passes.h"

#include "raycaster/composition.h"
#include "raycaster/direct_passes.h"
#include "raycaster/effects/effects.h"
#include "raycaster/effects/flow.h"
#include "raycaster/effects/occlusion.h"
#include "raycaster/effects/shadow.h"
#include "raycaster/field_passes.h"
#include "raycaster/shading.h"
#include "raycaster/slim_passes.h"
#include "raycaster/splat_passes.h"

namespace isocast {

std::vector<Pass> declare_passes(FrameContext& frame) {
    ImageSet hit_reads;
    if (frame.one != nullptr && frame.scene.quality.traversal == Traversal::BoundingFaces)
        hit_reads.insert(FrameImage::Bounds);
    if (frame.seen.splats) hit_reads.insert(FrameImage::Splat);
    ImageSet splat_reads;
    if (has_slims(frame)) splat_reads = {FrameImage::SlimNearest, FrameImage::SlimHit};
    hit_reads.insert(splat_reads);
    std::vector<Pass> passes{
        {"bounds", {}, FrameImage::Bounds, [&frame] { run_bounds(frame); }},
        {"slim nearest", {}, FrameImage::SlimNearest, [&frame] { run_slim_nearest(frame); }},
        {"slim hits",
         {FrameImage::SlimNearest},
         FrameImage::SlimHit,
         [&frame] { run_slim_hits(frame); }},
        {"splats", splat_reads, FrameImage::Splat, [&frame] { run_splats(frame); }},
        {"splat surfaces", splat_reads, FrameImage::SplatSurface,
         [&frame] { run_splat_surfaces(frame); }},
        {"raycast", hit_reads, FrameImage::Hit, [&frame] { run_hits(frame); }},
        {"steps", {FrameImage::Hit}, FrameImage::Steps, [] {}},              // with the hits
        {"splat colour", {FrameImage::Hit}, FrameImage::SplatColour, [] {}}, // with the hits
        {"gradient", {FrameImage::Hit}, FrameImage::Gradient, [&frame] { run_gradient(frame); }},
        {"curvature",
         {FrameImage::Hit},
         FrameImage::Curvature,
         [&frame] { run_second_order(frame, FrameImage::Curvature); }},
        {"view curvature",
         {FrameImage::Hit},
         FrameImage::ViewCurvature,
         [&frame] { run_second_order(frame, FrameImage::ViewCurvature); }},
        {"flow line curvature",
         {FrameImage::Hit},
         FrameImage::FlowLineCurvature,
         [&frame] { run_second_order(frame, FrameImage::FlowLineCurvature); }},
        {"direction",
         {FrameImage::Hit},
         FrameImage::Direction,
         [&frame] { run_second_order(frame, FrameImage::Direction); }},
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
        {"uncertainty",
         {FrameImage::Hit, FrameImage::Gradient, FrameImage::FlowLineCurvature},
         FrameImage::Uncertainty,
         [&frame] { run_uncertainty(frame); }},
        {"accessibility",
         {FrameImage::Curvature},
         FrameImage::Accessibility,
         [&frame] { run_accessibility(frame); }},
        {"shadow map", {}, FrameImage::ShadowMap, [&frame] { run_shadow_map(frame); }},
        {"shadow",
         {FrameImage::Hit, FrameImage::Gradient, FrameImage::ShadowMap},
         FrameImage::Shadow,
         [&frame] { run_shadow(frame); }},
        {"occlusion",
         {FrameImage::Hit, FrameImage::Gradient},
         FrameImage::Occlusion,
         [&frame] { run_occlusion(frame); }},
        {"refraction",
         {FrameImage::Hit, FrameImage::Gradient},
         FrameImage::Refraction,
         [&frame] { run_refraction(frame); }},
        {"reflection",
         {FrameImage::Hit, FrameImage::Gradient},
         FrameImage::Reflection,
         [&frame] { run_reflection(frame); }},
        {"ridges",
         {FrameImage::Hit, FrameImage::Curvature},
         FrameImage::Ridges,
         [&frame] { run_ridges(frame); }},
        {"contours",
         {FrameImage::Hit, FrameImage::Gradient, FrameImage::ViewCurvature},
         FrameImage::Contours,
         [&frame] { run_contours(frame); }},
        {"outline source",
         {FrameImage::Hit, FrameImage::Gradient},
         FrameImage::OutlineSource,
         [&frame] { run_outline_source(frame); }},
        {"outlines",
         {FrameImage::OutlineSource},
         FrameImage::Outlines,
         [&frame] { run_outlines(frame); }},
        {"slice", {FrameImage::Hit}, FrameImage::Slice, [&frame] { run_slice(frame); }},
    };
    for (Pass& pass : flow_passes(frame)) passes.push_back(std::move(pass));
    if (frame.scene.quality.splats == SplatShading::Direct)
        passes.push_back({"direct shading", direct_reads(frame), FrameImage::Beauty,
                          [&frame] { run_direct(frame); }});
    else
        passes.push_back({"shading", shading_reads(frame), FrameImage::Beauty,
                          [&frame] { run_shading(frame); }});
    return passes;
}

std::vector<gl::ProgramKey> all_programs() {
    std::vector<gl::ProgramKey> keys = field_programs();
    for (const std::vector<gl::ProgramKey>& more :
         {composition_programs(), splat_programs(), direct_programs(), solid_texture_programs(),
          curvature_colour_programs(), curvature_map_programs(), uncertainty_programs(),
          flow_programs(), accessibility_programs(), occlusion_programs(), shadow_programs(),
          refraction_programs(), reflection_programs(), ridges_programs(), contours_programs(),
          outlines_programs(), slice_programs(), shading_programs()})
        keys.insert(keys.end(), more.begin(), more.end());
    return keys;
}

} // namespace isocast
