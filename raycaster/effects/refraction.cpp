// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/effects.h"
#include "raycaster/environment.h"

namespace isocast {

namespace {

gl::ProgramKey refraction_program() {
    return {{"common/tiles.vert", "shading/refraction/refraction.frag"}, {}};
}

} // namespace

void run_refraction(FrameContext& frame) {
    const gl::Program& program = frame.shaders.program(refraction_program());
    set_surface_uniforms(program, frame);
    bind_environment(frame);
    program.set("u_index", static_cast<float>(frame.scene.look.effects.refraction.index));
    draw_tiles(frame, FrameImage::Refraction, program, Eigen::Vector4f::Zero());
}

std::vector<gl::ProgramKey> refraction_programs() {
    return {refraction_program()};
}

} // namespace isocast
