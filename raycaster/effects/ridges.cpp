// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/effects.h"
#include "raycaster/effects/hit_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isocast {

void run_ridges(FrameContext& frame) {
    const Ridges& ridges = frame.scene.look.effects.ridges;
    std::optional<double> threshold = ridges.threshold;
    if (!threshold) {
        // Against the strongest curvatures of all, not only those of ridges: a surface without any,
        // like a sphere, shows none.
        threshold =
            percentile(frame, "ridge threshold", FrameImage::Curvature, 0.95, [](const float* k) {
                return 0.5 * std::max(std::abs(k[0]), std::abs(k[1]));
            });
        // On a plane that is noise: a radian within 1000 voxels at least.
        const double least = 1 / (1000 * detail_world(frame));
        if (threshold) threshold = std::max(*threshold, least);
        if (threshold)
            frame.notes.push_back(fmt::format("ridges: threshold {:.3g} per unit", *threshold));
    }
    const gl::Program& program = frame.shaders.program(ridges_programs().front());
    frame.targets.texture(FrameImage::Curvature).bind_to_unit(0);
    program.set("u_threshold", static_cast<float>(threshold.value_or(1)));
    program.set("u_ridge_colour", Eigen::Vector3f(ridges.ridge_colour.cast<float>()));
    program.set("u_valley_colour", Eigen::Vector3f(ridges.valley_colour.cast<float>()));
    draw_tiles(frame, FrameImage::Ridges, program, Eigen::Vector4f::Zero());
}

std::vector<gl::ProgramKey> ridges_programs() {
    return {{{"common/tiles.vert", "shading/ridges/ridges.frag"}, {}}};
}

} // namespace isocast
