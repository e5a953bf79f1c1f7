// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/occlusion.h"

#include "raycaster/field_passes.h"
#include "volume/errors.h"

#include <fmt/format.h>

namespace isocast {

namespace {

gl::ProgramKey occlusion_program(std::map<std::string, std::string> defines) {
    defines["TRAVERSAL"] = std::to_string(static_cast<int>(Traversal::Walk));
    return {{"common/tiles.vert", "shading/occlusion/occlusion.frag"}, std::move(defines)};
}

} // namespace

void run_occlusion(FrameContext& frame) {
    const Occlusion& occlusion = frame.scene.look.effects.occlusion;
    const FieldOnGpu& field = frame.field;
    if (is_composed(frame.scene))
        throw InputError("ambient occlusion is for one object; composed ones have none yet");
    if (!field.pool().holds_all())
        throw ResourceError("all bricks must fit the texture budget for ambient occlusion");
    const gl::Program& program = frame.shaders.program(occlusion_program(field.pool().defines()));
    double distance = occlusion.distance_world.value_or(0);
    if (!occlusion.distance_world) {
        const std::array<Vec3d, 8> box = frame.surface_box_world();
        distance = (box.back() - box.front()).norm() / 10;
        frame.notes.push_back(
            fmt::format("ambient occlusion: occluders within {:.3g} world units", distance));
    }
    field.bind(program);
    frame.targets.texture(FrameImage::Hit).bind_to_unit(3);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(4);
    set_hit_uniforms(program, frame, field);
    set_extent_uniforms(program, frame);
    set_accuracy_uniforms(program, frame);
    program.set(
        "u_ray_vector",
        Eigen::Matrix3f(
            world_vector_coefficients(frame.camera, frame.width, frame.height).cast<float>()));
    program.set("u_rays", occlusion.rays);
    program.set("u_distance_world", static_cast<float>(distance));
    // 1/64 voxel: hits are known to 1e-5, and coordinates of a thousand voxels to 6e-5.
    program.set("u_lift_world",
                static_cast<float>(frame.object.field->space().voxel_size_world() / 64));
    draw_tiles(frame, FrameImage::Occlusion, program, {1, 0, 0, 0});
}

std::vector<gl::ProgramKey> occlusion_programs() {
    std::vector<gl::ProgramKey> keys;
    for (const std::map<std::string, std::string>& defines : all_pool_defines())
        keys.push_back(occlusion_program(defines));
    return keys;
}

} // namespace isocast
