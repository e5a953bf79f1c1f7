// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/shadow.h"

#include "raycaster/field_passes.h"
#include "raycaster/shading.h"
#include "raycaster/splat_passes.h"

#include <glad/gl.h>

#include <cmath>
#include <numbers>

namespace isocast {

namespace {

gl::ProgramKey depth_program() {
    return {{"common/tiles.vert", "shading/shadow/depth.frag"}, {}};
}

gl::ProgramKey shadow_program(Shadow shadow) {
    return {{"common/tiles.vert", "shading/shadow/shadow.frag"},
            {{"IS_SOFT", shadow == Shadow::Soft ? "1" : "0"}}};
}

/// World axes to light space [texels]: x, y as gl_FragCoord of the map, z along the light's rays.
Mat3d light_from_world(const LightView& light) {
    const Mat3d view_from_world = light.camera.view_from_world_rotation();
    return Vec3d(1, 1, -1).asDiagonal() * view_from_world / light.texel_world;
}

} // namespace

LightView light_view(const Light& light, const Camera& viewer, int pixels,
                     const std::array<Vec3d, 8>& box_world, double margin_world) {
    constexpr int border = 2; // texels at each side; no rounding fills them
    const Vec3d direction = direction_world(light, viewer);
    Vec3d middle = Vec3d::Zero();
    for (const Vec3d& corner : box_world) middle += corner / 8;
    LightView view;
    view.camera = {.eye_world = middle + direction,
                   .target_world = middle,
                   .projection = Projection::Orthographic};
    int across = 0;
    direction.cwiseAbs().minCoeff(&across);
    view.camera.up = Vec3d::Unit(across);
    const Mat3d view_from_world = view.camera.view_from_world_rotation();
    Vec3d half = Vec3d::Zero();
    for (const Vec3d& corner : box_world)
        half = half.cwiseMax((view_from_world * (corner - middle)).cwiseAbs());
    half.array() += margin_world;
    view.texel_world = 2 * half.head<2>().maxCoeff() / (pixels - 2 * border);
    const auto texels = [&](double half_side) {
        return 2 * border + static_cast<int>(std::ceil(2 * half_side / view.texel_world - 1e-9));
    };
    view.width = texels(half.x());
    view.height = texels(half.y());
    view.camera.eye_world = middle + half.z() * direction;
    view.camera.height_world = view.height * view.texel_world;
    return view;
}

void run_shadow_map(FrameContext& frame) {
    const LightView& light = *frame.light;
    OwnFrame of_light(frame, light.camera, light.width, light.height); // gone with this pass
    const bool has_fields = of_light.frame.one != nullptr;
    if (has_fields) cast_rays(of_light.frame);
    frame.targets.framebuffer(FrameImage::ShadowMap).bind();
    const Eigen::Vector4f nowhere = Eigen::Vector4f::Constant(1e30F); // as depth.frag's
    glClearBufferfv(GL_COLOR, 0, nowhere.data());
    if (!has_fields) {
        draw_splat_distances(of_light.frame, light.texel_world);
        return;
    }
    const gl::Program& program = frame.shaders.program(depth_program());
    of_light.targets.texture(FrameImage::Hit).bind_to_unit(0);
    program.set("u_depth",
                Eigen::Vector3f(light_from_world(light).row(2).transpose().cast<float>()));
    draw_on_tiles(of_light.frame, program);
}

void set_shadow_uniforms(const gl::Program& program, const FrameContext& frame) {
    const Light& casting = *casting_light(frame.scene.look);
    const LightView& light = *frame.light;
    frame.targets.texture(FrameImage::ShadowMap).bind_to_unit(2);
    const Mat3d to_light = light_from_world(light);
    const Vec3d eye = to_light * (frame.camera.eye_world - light.camera.eye_world) +
                      Vec3d(light.width, light.height, 0) / 2;
    program.set("u_light_from_world", Eigen::Matrix3f(to_light.cast<float>()));
    program.set("u_eye_light", Eigen::Vector3f(eye.cast<float>()));
    if (casting.shadow == Shadow::Soft)
        program.set("u_spread",
                    static_cast<float>(std::tan(casting.size_degrees * std::numbers::pi / 360)));
}

void run_shadow(FrameContext& frame) {
    const gl::Program& program =
        frame.shaders.program(shadow_program(casting_light(frame.scene.look)->shadow));
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(1);
    set_shadow_uniforms(program, frame);
    program.set(
        "u_ray_vector",
        Eigen::Matrix3f(
            world_vector_coefficients(frame.camera, frame.width, frame.height).cast<float>()));
    draw_tiles(frame, FrameImage::Shadow, program, {1, 0, 0, 0});
}

std::vector<gl::ProgramKey> shadow_programs() {
    return {depth_program(), shadow_program(Shadow::Hard), shadow_program(Shadow::Soft)};
}

} // namespace isocast
