// SPDX-License-Identifier: MPL-2.0
#include "raycaster/direct_passes.h"

#include "raycaster/effects/shadow.h"
#include "raycaster/shading.h"
#include "raycaster/splat_passes.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glad/gl.h>

#include <algorithm>

namespace isocast {

namespace {

gl::ProgramKey direct_program(SplatKind kind, bool is_perspective, const CutKind& cut,
                              bool has_normals, std::size_t lights, Shadow shadow) {
    gl::ProgramKey key = splat_program(kind, is_perspective, cut, SplatOutput::Colour, has_normals);
    for (const auto& [name, value] : {std::pair{"LIGHTS", static_cast<int>(lights)},
                                      {"HAS_SHADOW", shadow != Shadow::None},
                                      {"IS_SOFT", shadow == Shadow::Soft}})
        key.defines[name] = std::to_string(value);
    return key;
}

double shadow_strength(const Look& look) {
    const std::vector<Layer> layers = layers_of(look);
    return std::ranges::find(layers, FrameImage::Shadow, &Layer::image)->strength;
}

} // namespace

void check_direct(const Look& look, bool has_fields, bool has_slims) {
    std::vector<std::string> wrong;
    if (has_fields) wrong.emplace_back("fields");
    if (has_slims) wrong.emplace_back("SLIM surfaces");
    if (look.model != ShadingModel::BlinnPhong) wrong.emplace_back("other models than blinn-phong");
    if (look.shows_environment) wrong.emplace_back("the environment");
    for (const Layer& layer : layers_of(look))
        if (layer.strength > 0 && layer.image != FrameImage::Shadow)
            wrong.emplace_back(name_of(layer.image));
    if (!wrong.empty())
        throw InputError(fmt::format("direct splats show primitives by Phong with shadows; what "
                                     "they cannot draw, and deferred ones can: {}",
                                     fmt::join(wrong, ", ")));
}

ImageSet direct_reads(const FrameContext& frame) {
    return shadow_strength(frame.scene.look) > 0 && !frame.seen.splats->kinds.empty()
               ? ImageSet{FrameImage::ShadowMap}
               : ImageSet{};
}

void run_direct(FrameContext& frame) {
    const Look& look = frame.scene.look;
    const double strength = shadow_strength(look);
    const Shadow shadow = strength > 0 ? casting_light(look)->shadow : Shadow::None;
    Eigen::Vector4f background = Eigen::Vector4f::Zero();
    background.head<3>() = look.background.cast<float>();
    frame.seen.splats->of_scene->colours.texture.bind_to_unit(4);
    draw_nearest_splats(
        frame, FrameImage::Beauty, background,
        [&](SplatKind kind) {
            return direct_program(kind, is_perspective(frame), cut_kind_of(frame),
                                  has_normals(*frame.seen.splats), lights_of(look).size(), shadow);
        },
        [&](const gl::Program& program, const SplatsOnGpu::OfKind&) {
            program.set("u_ray_vector", Eigen::Matrix3f(world_vector_coefficients(
                                                            frame.camera, frame.width, frame.height)
                                                            .cast<float>()));
            set_lights(program, frame);
            if (shadow == Shadow::None) return;
            set_shadow_uniforms(program, frame);
            program.set("u_shadow_strength", static_cast<float>(strength));
        });
}

std::vector<gl::ProgramKey> direct_programs() {
    std::vector<gl::ProgramKey> keys;
    for (const bool is_perspective : {false, true})
        for (int k = 0; k < splat_kind_count; ++k) {
            const auto kind = static_cast<SplatKind>(k);
            if (kind == SplatKind::Slim) continue;
            for (const Shadow shadow : {Shadow::None, Shadow::Hard, Shadow::Soft})
                keys.push_back(direct_program(kind, is_perspective, {}, false, 1, shadow));
            keys.push_back(
                direct_program(kind, is_perspective, {1, CutLook::Capped}, true, 2, Shadow::Soft));
        }
    return keys;
}

} // namespace isocast
