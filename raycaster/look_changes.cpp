// SPDX-License-Identifier: MPL-2.0
#include "raycaster/look_changes.h"

#include "raycaster/shading.h"

namespace isocast {

namespace {

template<class Effect>
bool is_alike(Effect before, const Effect& after) {
    before.strength = after.strength;
    return before == after;
}

/// How much of the light arrives depends on neither its colour nor the shadow's strength.
bool casts_alike(const Light* before, const Light* after) {
    if (before == nullptr || after == nullptr) return before == after;
    Light light = *before;
    light.colour = after->colour;
    light.shadow_strength = after->shadow_strength;
    return light == *after;
}

} // namespace

ImageSet images_changed(const Look& before, const Look& after) {
    ImageSet changed;
    const auto unless = [&](bool is_same, FrameImage image) {
        if (!is_same) changed.insert(image);
    };
    const Effects& old = before.effects;
    const Effects& now = after.effects;
    const bool has_same_sky = before.environment == after.environment;
    const bool has_same_index = old.refraction.index == now.refraction.index;
    unless(is_alike(old.solid_texture, now.solid_texture), FrameImage::SolidTexture);
    unless(is_alike(old.curvature_colour, now.curvature_colour), FrameImage::CurvatureColour);
    unless(is_alike(old.curvature_map, now.curvature_map), FrameImage::CurvatureMap);
    unless(is_alike(old.uncertainty, now.uncertainty), FrameImage::Uncertainty);
    unless(is_alike(old.flow, now.flow), FrameImage::Flow);
    unless(old.flow.grain_pixels == now.flow.grain_pixels, FrameImage::FlowNoise);
    unless(is_alike(old.accessibility, now.accessibility), FrameImage::Accessibility);
    unless(is_alike(old.occlusion, now.occlusion), FrameImage::Occlusion);
    unless(has_same_sky && has_same_index, FrameImage::Refraction);
    unless(has_same_sky && is_alike(old.reflection, now.reflection) &&
               (has_same_index || !now.reflection.has_fresnel),
           FrameImage::Reflection);
    unless(is_alike(old.ridges, now.ridges), FrameImage::Ridges);
    unless(is_alike(old.contours, now.contours), FrameImage::Contours);
    unless(is_alike(old.outlines, now.outlines), FrameImage::Outlines);
    unless(is_alike(old.slice, now.slice), FrameImage::Slice);
    unless(casts_alike(casting_light(before), casting_light(after)), FrameImage::Shadow);
    unless(before == after, FrameImage::Beauty);
    return changed;
}

} // namespace isocast
