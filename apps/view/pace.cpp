// SPDX-License-Identifier: MPL-2.0
#include "apps/view/pace.h"

#include <algorithm>
#include <array>

namespace isocast::view {

namespace {

/// The passes that without_expensive_effects() does not run.
constexpr std::array expensive{"shadow map", "shadow", "occlusion",
                               "flow noise", "flow",   "direction"};

bool is_expensive(const std::string& pass) {
    return std::ranges::find(expensive, pass) != expensive.end();
}

/// Whether the look runs that pass: an effect that is off costs nothing, whatever it once took.
bool runs(const Look& look, const std::string& pass) {
    const Effects& e = look.effects;
    if (pass == "shadow map" || pass == "shadow")
        return std::ranges::any_of(look.lights,
                                   [](const Light& light) { return light.shadow != Shadow::None; });
    if (pass == "occlusion") return e.occlusion.strength > 0;
    if (pass == "flow noise" || pass == "flow" || pass == "direction") return e.flow.strength > 0;
    if (pass == "refraction") return e.refraction.strength > 0;
    if (pass == "reflection") return e.reflection.strength > 0;
    if (pass == "outlines" || pass == "outline source") return e.outlines.strength > 0;
    if (pass == "contours" || pass == "view curvature") return e.contours.strength > 0;
    if (pass == "solid texture") return e.solid_texture.strength > 0;
    if (pass == "curvature")
        return e.curvature_colour.strength > 0 || e.curvature_map.strength > 0 ||
               e.ridges.strength > 0 || e.accessibility.strength > 0;
    return true;
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

double Pace::milliseconds_per_pixel(const std::string& pass) const {
    const auto found = per_pixel_.find(pass);
    return found == per_pixel_.end() ? 0 : found->second;
}

double Pace::expected_milliseconds(const Look& look, double pixels, bool has_effects) const {
    double sum = 0;
    for (const auto& [pass, milliseconds] : per_pixel_)
        if (runs(look, pass) && (has_effects || !is_expensive(pass))) sum += milliseconds;
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
