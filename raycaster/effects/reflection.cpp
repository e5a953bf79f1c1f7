// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/effects.h"
#include "raycaster/environment.h"

namespace isocast {

namespace {

gl::ProgramKey reflection_program(bool has_fresnel) {
    return {{"common/tiles.vert", "shading/reflection/reflection.frag"},
            {{"HAS_FRESNEL", has_fresnel ? "1" : "0"}}};
}

} // namespace

void run_reflection(FrameContext& frame) {
    const Effects& effects = frame.scene.look.effects;
    const gl::Program& program =
        frame.shaders.program(reflection_program(effects.reflection.has_fresnel));
    set_surface_uniforms(program, frame);
    bind_environment(frame);
    if (effects.reflection.has_fresnel)
        program.set("u_index", static_cast<float>(effects.refraction.index));
    draw_tiles(frame, FrameImage::Reflection, program, Eigen::Vector4f::Zero());
}

std::vector<gl::ProgramKey> reflection_programs() {
    return {reflection_program(false), reflection_program(true)};
}

} // namespace isocast
