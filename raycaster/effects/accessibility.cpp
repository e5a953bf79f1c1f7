// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/effects.h"
#include "raycaster/effects/hit_statistics.h"

#include <fmt/format.h>

#include <algorithm>

namespace isocast {

namespace {

gl::ProgramKey accessibility_program() {
    return {{"common/tiles.vert", "shading/accessibility/accessibility.frag"}, {}};
}

/// A ball of this radius does not fit into the tightest 5 % of the picture's concave places.
/// Nothing where none of these is seen.
std::optional<double> radius_of(FrameContext& frame) {
    const double flat = flat_curvature(frame);
    const auto found = percentile(frame, "accessibility", FrameImage::Curvature, 0.95,
                                  [&](const float* k) -> std::optional<double> {
                                      if (k[3] == no_gradient || k[1] >= -flat) return {};
                                      return -k[1];
                                  });
    if (!found) return std::nullopt;
    frame.notes.push_back(
        fmt::format("accessibility: black where a ball of {:.4g} does not fit", 1 / *found));
    return 1 / *found;
}

} // namespace

void run_accessibility(FrameContext& frame) {
    const Accessibility& accessibility = frame.scene.look.effects.accessibility;
    const auto radius = accessibility.radius_world ? accessibility.radius_world : radius_of(frame);
    const gl::Program& program = frame.shaders.program(accessibility_program());
    frame.targets.texture(FrameImage::Curvature).bind_to_unit(0);
    program.set("u_radius", static_cast<float>(radius.value_or(0)));
    draw_tiles(frame, FrameImage::Accessibility, program, Eigen::Vector4f::Zero());
}

std::vector<gl::ProgramKey> accessibility_programs() {
    return {accessibility_program()};
}

} // namespace isocast
