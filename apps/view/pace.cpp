// SPDX-License-Identifier: MPL-2.0
#include "apps/view/pace.h"

#include "raycaster/shading.h"

#include <algorithm>
#include <array>

namespace isocast::view {

namespace {

/// Those that without_expensive_effects() leaves out.
const ImageSet expensive{FrameImage::Shadow, FrameImage::Occlusion, FrameImage::Flow};

/// Whose images passes that are no effect's own are made for.
constexpr std::array made_for{std::pair{"shadow map", FrameImage::Shadow},
                              std::pair{"flow noise", FrameImage::Flow},
                              std::pair{"direction", FrameImage::Flow},
                              std::pair{"outline source", FrameImage::Outlines},
                              std::pair{"view curvature", FrameImage::Contours},
                              std::pair{"flow line curvature", FrameImage::Uncertainty},
                              std::pair{"curvature", FrameImage::CurvatureColour},
                              std::pair{"curvature", FrameImage::CurvatureMap},
                              std::pair{"curvature", FrameImage::Accessibility},
                              std::pair{"curvature", FrameImage::Ridges}};

/// Whether the look runs that pass: an effect that is off costs nothing, whatever it once took.
bool runs(const Look& look, const std::string& pass, bool has_expensive) {
    bool is_of_effect = false;
    for (const Layer& layer : layers_of(look)) {
        const bool is_its =
            pass == name_of(layer.image) || std::ranges::any_of(made_for, [&](const auto& one) {
                return pass == one.first && layer.image == one.second;
            });
        if (is_its && layer.strength > 0 && (has_expensive || !expensive.contains(layer.image)))
            return true;
        is_of_effect = is_of_effect || is_its;
    }
    return !is_of_effect;
}

} // namespace

void Pace::saw(const FrameReport& report, double pixels, double wall_milliseconds) {
    double sum = 0;
    for (const PassReport& pass : report.passes) {
        if (!pass.ran) continue;
        sum += pass.milliseconds;
        // The half of what is new: a frame that something else held up does not decide.
        const double now = pass.milliseconds / pixels;
        const auto [found, is_new] = per_pixel_.try_emplace(pass.name, now);
        if (!is_new) found->second = (found->second + now) / 2;
    }
    const double overhead = std::max(0.0, wall_milliseconds - sum);
    overhead_ = overhead_ == 0 ? overhead : (overhead_ + overhead) / 2;
}

double Pace::expected_milliseconds(const Look& look, double pixels, bool has_effects) const {
    double sum = 0;
    for (const auto& [pass, milliseconds] : per_pixel_)
        if (runs(look, pass, has_effects)) sum += milliseconds;
    return overhead_ + pixels * sum;
}

Reduction Pace::reduction_for(const Look& look, double pixels, double target_milliseconds) const {
    // Half the resolution shows less than effects that come and go; a quarter shows more.
    for (const auto& [has_effects, greatest] :
         {std::pair{true, 2}, std::pair{false, greatest_divisor}})
        for (int divisor = 1; divisor <= greatest; ++divisor)
            if (expected_milliseconds(look, pixels / (divisor * divisor), has_effects) <=
                target_milliseconds)
                return {divisor, has_effects};
    return {greatest_divisor, false};
}

Look without_expensive_effects(Look look) {
    for (Light& light : look.lights) light.shadow = Shadow::None;
    look.effects.occlusion.strength = 0;
    look.effects.flow.strength = 0;
    return look;
}

} // namespace isocast::view
