// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/flow.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

gl::ProgramKey noise_program() {
    return {{"common/tiles.vert", "shading/flow/flow_noise.frag"}, {}};
}

gl::ProgramKey flow_program(int direction, bool travels) {
    return {{"common/tiles.vert", "shading/flow/flow.frag"},
            {{"DIRECTION", std::to_string(direction)}, {"TRAVELS", travels ? "1" : "0"}}};
}

/// Pixels of a world unit at depth 1, or at any in parallel projection.
double pixels_per_world(const FrameContext& frame) {
    return frame.height / (2 * frame.camera.half_height_at(1));
}

void run_flow_noise(FrameContext& frame) {
    const Camera& camera = frame.camera;
    const Vec3d anchor = frame.seen.extents_world.front().front();
    const double grain = frame.scene.look.effects.flow.grain_pixels / pixels_per_world(frame);
    const bool is_perspective = camera.projection == Projection::Perspective;
    Eigen::Vector4d grain_at = Eigen::Vector4d::UnitW();
    if (is_perspective) grain_at << -camera.view_from_world_rotation().row(2).transpose(), 0;

    // Integers hold the eye's cell where cells are 2^-30 of its distance at least; and of hits
    // nearer to it than 2^-10 of that the grain does not shrink any more.
    const Vec3d eye = camera.eye_world - anchor;
    double reach = eye.norm();
    for (const std::array<Vec3d, 8>& corners : frame.seen.extents_world)
        for (const Vec3d& corner : corners)
            reach = std::max(reach, eye.norm() + (corner - anchor).norm());
    const double finest_grain = is_perspective ? grain * reach * 0x1p-10 : grain;
    const auto finest = static_cast<int>(
        std::max(std::floor(std::log2(finest_grain)), std::ceil(std::log2(reach * 0x1p-30))));
    const Vec3d eye_cells = eye * std::exp2(-finest);
    const Vec3d cell = eye_cells.array().floor();

    const gl::Program& program = frame.shaders.program(noise_program());
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    program.set("u_grain", Eigen::Vector4f((grain * grain_at).cast<float>()));
    program.set("u_finest", finest);
    program.set("u_eye_cell", Eigen::Vector3i(cell.cast<int>()));
    program.set("u_eye_place", Eigen::Vector3f((eye_cells - cell).cast<float>()));
    draw_tiles(frame, FrameImage::FlowNoise, program, Eigen::Vector4f::Zero());
}

void run_flow(FrameContext& frame) {
    const Flow& flow = frame.scene.look.effects.flow;
    const gl::Program& program =
        frame.shaders.program(flow_program(flow.direction, flow.phase.has_value()));
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.targets.texture(FrameImage::Direction).bind_to_unit(1);
    frame.targets.texture(FrameImage::FlowNoise).bind_to_unit(2);
    if (flow.direction == 2) frame.targets.texture(FrameImage::Gradient).bind_to_unit(3);

    const bool is_perspective = frame.camera.projection == Projection::Perspective;
    Mat3d screen = frame.camera.view_from_world_rotation();
    screen.topRows<2>() *= pixels_per_world(frame);
    screen.row(2) *= is_perspective ? -1 : 0;
    program.set("u_screen", Eigen::Matrix3f(screen.cast<float>()));
    program.set("u_depth", is_perspective ? 0.0F : 1.0F);
    program.set("u_steps", step_count(flow));
    // Neighbours along a line are alike as far as a grain reaches: a sum's variance is that of the
    // noise times its weights' squares times the grain in pixels. 0.3: nine factors of ten lie
    // between 0.5 and 1.5.
    program.set("u_contrast",
                static_cast<float>(0.3 / std::sqrt(std::max(1.0, flow.grain_pixels))));
    if (flow.phase) {
        program.set("u_phase", static_cast<float>(*flow.phase));
        // No sense of lines is consistent all over a surface; this one turns round where lines are
        // across it, which is along no axis of symmetry.
        program.set("u_forward", Eigen::Vector3f(Vec3d(0.36, 0.48, 0.80).cast<float>()));
    }
    draw_tiles(frame, FrameImage::Flow, program, Eigen::Vector4f(1, 1, 1, 0));
}

} // namespace

std::vector<Pass> flow_passes(FrameContext& frame) {
    ImageSet reads{FrameImage::Hit, FrameImage::Direction, FrameImage::FlowNoise};
    if (frame.scene.look.effects.flow.direction == 2) reads.insert(FrameImage::Gradient);
    return {{"flow noise",
             {FrameImage::Hit},
             FrameImage::FlowNoise,
             [&frame] { run_flow_noise(frame); }},
            {"flow", reads, FrameImage::Flow, [&frame] { run_flow(frame); }}};
}

std::vector<gl::ProgramKey> flow_programs() {
    std::vector<gl::ProgramKey> keys{noise_program()};
    for (const int direction : {1, 2})
        for (const bool travels : {false, true}) keys.push_back(flow_program(direction, travels));
    return keys;
}

int step_count(const Flow& flow) {
    return std::max(1, static_cast<int>(std::lround(flow.length_pixels / 2)));
}

void check(const Flow& flow) {
    if (flow.direction != 1 && flow.direction != 2)
        throw InputError(fmt::format("flow along principal direction {}: 1 or 2", flow.direction));
    if (!(flow.length_pixels > 0 && flow.length_pixels <= 1000) || !(flow.grain_pixels > 0))
        throw InputError(fmt::format("flow of lines of {} pixels with grains of {}: both must be "
                                     "above 0, and lines 1000 pixels at most",
                                     flow.length_pixels, flow.grain_pixels));
}

} // namespace isocast
