// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/occlusion.h"

#include "raycaster/composition.h"
#include "raycaster/field_passes.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <algorithm>

namespace isocast {

namespace {

gl::ProgramKey occlusion_program(std::map<std::string, std::string> defines) {
    defines["TRAVERSAL"] = std::to_string(static_cast<int>(Traversal::Walk));
    return {{"common/tiles.vert", "shading/occlusion/occlusion.frag"}, std::move(defines)};
}

const gl::ProgramKey count_program{{"common/tiles.vert", "shading/occlusion/count.frag"}, {}};

/// Of shaders/shading/occlusion/sky.glsl, and of the rays' way through an object's field.
void set_sky_uniforms(const gl::Program& program, const FrameContext& frame,
                      const Occlusion& occlusion, double distance_world) {
    frame.field().bind(program);
    frame.targets.texture(FrameImage::Hit).bind_to_unit(3);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(4);
    set_hit_uniforms(program, frame, frame.field());
    set_extent_uniforms(program, frame);
    set_accuracy_uniforms(program, frame);
    program.set(
        "u_view_vector",
        Eigen::Matrix3f(
            world_vector_coefficients(frame.camera, frame.width, frame.height).cast<float>()));
    program.set("u_rays", occlusion.rays);
    program.set("u_distance_world", static_cast<float>(distance_world));
}

/// Of rays' starts off the surface. 1/64 voxel: hits are known to 1e-5, and coordinates of a
/// thousand voxels to 6e-5.
double lift_world(const FrameObject& object) {
    return object.object.field->space().voxel_size_world() / 64;
}

/// Ray by ray, each through all objects.
void run_composed(FrameContext& frame, const Occlusion& occlusion, double distance_world) {
    double lift = 0;
    for (const FrameObject& object : frame.seen.objects) lift = std::max(lift, lift_world(object));
    const gl::Texture met = gl::Texture::image(gl::Format::Rgba32f, frame.part.width,
                                               frame.part.height, "what rays to the sky meet");
    frame.scratch_bytes += met.byte_count();
    const gl::Texture& seen = frame.targets.texture(FrameImage::Occlusion);
    frame.targets.framebuffer(FrameImage::Occlusion).bind();
    const Eigen::Vector4f all = Eigen::Vector4f::UnitX();
    glClearBufferfv(GL_COLOR, 0, all.data());
    const std::int64_t scratch_bytes = frame.scratch_bytes;
    for (int ray = 0; ray < occlusion.rays; ++ray) {
        frame.scratch_bytes = scratch_bytes; // what the ray before took is gone
        compose_roots(
            frame, met, [&](const FrameContext& object, int number) -> const gl::Program& {
                const gl::Program& program =
                    object.shaders.program(sky_operand_program(object.field().pool().defines()));
                set_sky_uniforms(program, object, occlusion, distance_world);
                set_operand_uniforms(program, frame, number);
                const Mat3d& axes = object.object().field->space().world_from_index.linear();
                program.set("u_world_from_index", Eigen::Matrix3f(axes.cast<float>()));
                program.set("u_lift_world", static_cast<float>(lift));
                program.set("u_ray", ray);
                return program;
            });
        const gl::Program& program = frame.shaders.program(count_program);
        met.bind_to_unit(0);
        seen.bind_to_unit(1);
        program.set("u_rays", occlusion.rays);
        frame.targets.framebuffer(FrameImage::Occlusion).bind();
        glTextureBarrier();
        draw_on_tiles(frame, program);
    }
}

} // namespace

void run_occlusion(FrameContext& frame) {
    const Occlusion& occlusion = frame.scene.look.effects.occlusion;
    if (frame.seen.splats)
        throw InputError(
            "ambient occlusion is for fields; spheres and other primitives have none yet");
    const FieldOnGpu& field = frame.field();
    if (!field.pool().holds_all())
        throw ResourceError("all bricks must fit the texture budget for ambient occlusion");
    double distance = occlusion.distance_world.value_or(0);
    if (!occlusion.distance_world) {
        const std::array<Vec3d, 8> box = frame.surface_box_world();
        distance = (box.back() - box.front()).norm() / 10;
        frame.notes.push_back(
            fmt::format("ambient occlusion: occluders within {:.3g} world units", distance));
    }
    if (is_composed(frame.scene)) {
        run_composed(frame, occlusion, distance);
        return;
    }
    const gl::Program& program = frame.shaders.program(occlusion_program(field.pool().defines()));
    set_sky_uniforms(program, frame, occlusion, distance);
    program.set("u_lift_world", static_cast<float>(lift_world(frame.seen.objects.front())));
    draw_tiles(frame, FrameImage::Occlusion, program, {1, 0, 0, 0});
}

std::vector<gl::ProgramKey> occlusion_programs() {
    std::vector<gl::ProgramKey> keys;
    for (const std::map<std::string, std::string>& defines : all_pool_defines())
        for (const gl::ProgramKey& key : {occlusion_program(defines), sky_operand_program(defines)})
            keys.push_back(key);
    keys.push_back(count_program);
    return keys;
}

} // namespace isocast
