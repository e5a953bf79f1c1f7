// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/effects.h"
#include "raycaster/effects/hit_statistics.h"

#include <fmt/format.h>

#include <algorithm>

namespace isocast {

void run_uncertainty(FrameContext& frame) {
    const Uncertainty& uncertainty = frame.scene.look.effects.uncertainty;
    std::optional<double> range = uncertainty.range;
    if (!range) {
        range = percentile(frame, "uncertainty range", FrameImage::FlowLineCurvature, 0.98,
                           [](const float* curvature) { return curvature[0]; });
        // In a field of distances that is noise: a radian within 32 voxels at least.
        const double least = 1 / (32 * detail_world(frame));
        if (range) range = std::max(*range, least);
    }
    std::optional<double> gradient = uncertainty.typical_gradient;
    if (!gradient)
        gradient = percentile(frame, "typical gradient", FrameImage::Gradient, 0.5,
                              [](const float* g) { return Vec3d(g[0], g[1], g[2]).norm(); });
    if (range && gradient)
        frame.notes.push_back(fmt::format(
            "uncertainty: flow lines that turn by {:.3g} per unit, gradients far below {:.3g}",
            *range, *gradient));
    const gl::Program& program = frame.shaders.program(uncertainty_programs().front());
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(1);
    frame.targets.texture(FrameImage::FlowLineCurvature).bind_to_unit(2);
    program.set("u_range", static_cast<float>(range.value_or(1)));
    program.set("u_typical_gradient", static_cast<float>(gradient.value_or(1)));
    program.set("u_colour", Eigen::Vector3f(uncertainty.colour.cast<float>()));
    draw_tiles(frame, FrameImage::Uncertainty, program, Eigen::Vector4f::Zero());
}

std::vector<gl::ProgramKey> uncertainty_programs() {
    return {{{"common/tiles.vert", "shading/uncertainty/uncertainty.frag"}, {}}};
}

} // namespace isocast
