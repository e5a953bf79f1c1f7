// SPDX-License-Identifier: MPL-2.0
#include "raycaster/shading.h"

#include "raycaster/environment.h"

#include <fmt/format.h>

#include <algorithm>

namespace isocast {

namespace {

constexpr int first_layer_unit =
    2; // of shaders/shading/layers.glsl; the environment has the last, 15

/// of_splats  reads FrameImage::SplatSurface
gl::ProgramKey shading_program(ShadingModel model, bool shows_environment, std::size_t lights,
                               std::size_t objects, const std::map<Blend, std::size_t>& counts,
                               bool of_splats = false) {
    const auto count = [&](Blend blend) {
        const auto found = counts.find(blend);
        return std::to_string(found == counts.end() ? 0 : found->second);
    };
    return {{"common/tiles.vert", "shading/shading.frag"},
            {{"MODEL", std::to_string(static_cast<int>(model))},
             {"SHOWS_ENVIRONMENT", shows_environment ? "1" : "0"},
             {"LIGHTS", std::to_string(model == ShadingModel::Flat ? 0 : lights)},
             {"OBJECTS", std::to_string(objects)},
             {"OF_SPLATS", of_splats ? "1" : "0"},
             {"SURFACE_LAYERS", count(Blend::SurfaceColour)},
             {"SURFACE_FACTORS", count(Blend::SurfaceFactor)},
             {"AMBIENT_FACTORS", count(Blend::AmbientLight)},
             {"SHADOWS", count(Blend::DirectLight)},
             {"OVERLAYS", count(Blend::Overlay)}}};
}

/// The live layers by kind: shaders read them in the order of the kinds.
std::vector<Layer> live_layers(const FrameContext& frame) {
    const Look& look = frame.scene.look;
    std::vector<Layer> layers = layers_of(look);
    if (frame.seen.splats)
        layers.insert(layers.begin(), {FrameImage::SplatColour, Blend::SurfaceColour, 1});
    std::erase_if(layers, [&](const Layer& layer) {
        const bool is_anywhere = layer.image == FrameImage::Slice;
        if (frame.places.run_count == 0 && !is_anywhere) return true;
        // Unlit colours know no light.
        const bool is_light =
            layer.blend == Blend::AmbientLight || layer.blend == Blend::DirectLight;
        return layer.strength == 0 || (is_light && look.model == ShadingModel::Flat);
    });
    std::ranges::stable_sort(layers, {}, &Layer::blend);
    return layers;
}

/// Primitives alone, of which nothing else reads hits, normals and colours.
bool shades_splats(const FrameContext& frame, const std::vector<Layer>& layers) {
    return frame.seen.splats && frame.seen.objects.empty() &&
           std::ranges::all_of(
               layers, [](const Layer& layer) { return layer.image == FrameImage::SplatColour; });
}

Eigen::Vector3f to_float(const Vec3d& v) {
    return v.cast<float>();
}

} // namespace

std::vector<Layer> layers_of(const Look& look) {
    const Effects& e = look.effects;
    const Light* light = casting_light(look);
    const double shadow_strength =
        light != nullptr && light->colour != Vec3d::Zero() ? light->shadow_strength : 0;
    return {
        {FrameImage::SolidTexture, Blend::SurfaceColour, e.solid_texture.strength},
        {FrameImage::CurvatureColour, Blend::SurfaceColour, e.curvature_colour.strength},
        {FrameImage::CurvatureMap, Blend::SurfaceColour, e.curvature_map.strength},
        {FrameImage::Uncertainty, Blend::SurfaceColour, e.uncertainty.strength},
        {FrameImage::Flow, Blend::SurfaceFactor, e.flow.strength},
        {FrameImage::Ridges, Blend::SurfaceColour, e.ridges.strength},
        {FrameImage::Accessibility, Blend::SurfaceColour, e.accessibility.strength},
        {FrameImage::Occlusion, Blend::AmbientLight, e.occlusion.strength},
        {FrameImage::Shadow, Blend::DirectLight, shadow_strength},
        {FrameImage::Refraction, Blend::Overlay, e.refraction.strength},
        {FrameImage::Reflection, Blend::Overlay, e.reflection.strength},
        {FrameImage::Contours, Blend::Overlay, e.contours.strength},
        {FrameImage::Outlines, Blend::Overlay, e.outlines.strength, true},
        {FrameImage::Slice, Blend::Overlay, e.slice.strength},
    };
}

const Light* casting_light(const Look& look) {
    const auto light =
        std::ranges::find_if(look.lights, [](const Light& l) { return l.shadow != Shadow::None; });
    return light == look.lights.end() ? nullptr : &*light;
}

ImageSet shading_reads(const FrameContext& frame) {
    const std::vector<Layer> layers = live_layers(frame);
    if (shades_splats(frame, layers)) return {FrameImage::SplatSurface};
    ImageSet reads{FrameImage::Hit};
    if (frame.scene.look.model != ShadingModel::Flat) reads.insert(FrameImage::Gradient);
    for (const Layer& layer : layers) reads.insert(layer.image);
    return reads;
}

std::vector<Light> lights_of(const Look& look) {
    if (look.lights.empty()) return {Light{.colour = Vec3d::Zero()}};
    return look.lights;
}

void set_lights(const gl::Program& program, const FrameContext& frame) {
    const Look& look = frame.scene.look;
    const std::vector<Light> lights = lights_of(look);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const Light& light = lights[i];
        program.set(fmt::format("u_light_directions[{}]", i).c_str(),
                    to_float(direction_world(light, frame.camera)));
        program.set(fmt::format("u_light_colours[{}]", i).c_str(), to_float(light.colour));
        if (light.shadow != Shadow::None && program.has("u_shadowed_light"))
            program.set("u_shadowed_light", static_cast<int>(i));
    }
    const Material& material = look.material;
    program.set("u_material", Eigen::Vector4f(float(material.ambient), float(material.diffuse),
                                              float(material.specular), float(material.shininess)));
}

void run_shading(FrameContext& frame) {
    const Look& look = frame.scene.look;
    std::vector<Layer> layers = live_layers(frame);
    const bool of_splats = shades_splats(frame, layers);
    if (of_splats) layers.clear(); // colours come with the surfaces
    std::map<Blend, std::size_t> counts;
    for (const Layer& layer : layers) ++counts[layer.blend];
    const std::size_t owners =
        frame.seen.objects.size() + std::size_t{frame.seen.splats.has_value()};
    const gl::Program& program = frame.shaders.program(shading_program(
        look.model, look.shows_environment, lights_of(look).size(), owners, counts, of_splats));

    if (of_splats) {
        frame.targets.texture(FrameImage::SplatSurface).bind_to_unit(0);
        const PrimitivesOnGpu& of_scene = *frame.seen.splats->of_scene;
        of_scene.colours.texture.bind_to_unit(1);
        program.set("u_to_half_colours", of_scene.to_half_colours);
        if (look.model != ShadingModel::Flat)
            program.set("u_world_from_view", world_from_view(frame));
    } else {
        frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
        if (look.model != ShadingModel::Flat)
            frame.targets.texture(FrameImage::Gradient).bind_to_unit(1);
    }
    int unit = first_layer_unit;
    std::map<Blend, int> numbers;
    for (const Layer& layer : layers) {
        frame.targets.texture(layer.image).bind_to_unit(static_cast<unsigned>(unit++));
        const char* name = layer.blend == Blend::SurfaceColour   ? "u_surface_strengths"
                           : layer.blend == Blend::SurfaceFactor ? "u_factor_strengths"
                           : layer.blend == Blend::AmbientLight  ? "u_ambient_strengths"
                           : layer.blend == Blend::DirectLight   ? "u_shadow_strengths"
                                                                 : "u_overlay_strengths";
        program.set(fmt::format("{}[{}]", name, numbers[layer.blend]++).c_str(),
                    static_cast<float>(layer.strength));
    }

    const Material& material = look.material;
    for (std::size_t i = 0; i < frame.seen.objects.size(); ++i) {
        const FieldObject& object = frame.seen.objects[i].object;
        const Vec3d colour = object.colour.value_or(material.colour);
        program.set(fmt::format("u_colours[{}]", i).c_str(), to_float(colour));
        if (owners > 1)
            program.set(fmt::format("u_colours[{}]", owners + i).c_str(),
                        to_float(object.cut_colour.value_or(colour)));
    }
    if (look.model != ShadingModel::Flat) {
        set_lights(program, frame);
        if (look.model == ShadingModel::Gooch) {
            program.set("u_cool", to_float(look.tones.cool));
            program.set("u_warm", to_float(look.tones.warm));
            program.set("u_shares", Eigen::Vector2f(float(look.tones.cool_share),
                                                    float(look.tones.warm_share)));
        }
    }
    if (look.model != ShadingModel::Flat || look.shows_environment)
        program.set(
            "u_ray_vector",
            Eigen::Matrix3f(
                world_vector_coefficients(frame.camera, frame.width, frame.height).cast<float>()));
    if (look.shows_environment)
        bind_environment(frame);
    else
        program.set("u_background", to_float(look.background));
    if (look.shows_environment || look.effects.slice.strength > 0) {
        draw_everywhere(frame, FrameImage::Beauty, program);
        return;
    }
    Eigen::Vector4f background = Eigen::Vector4f::Zero();
    background.head<3>() = to_float(look.background);
    const bool reaches_beyond_hits =
        std::ranges::any_of(layers, [](const Layer& layer) { return layer.reaches_beyond_hits; });
    (reaches_beyond_hits ? draw_around_tiles : draw_tiles)(frame, FrameImage::Beauty, program,
                                                           background);
}

std::vector<gl::ProgramKey> shading_programs() {
    std::vector<gl::ProgramKey> keys;
    for (const ShadingModel model :
         {ShadingModel::BlinnPhong, ShadingModel::Gooch, ShadingModel::Flat})
        for (const bool shows_environment : {false, true})
            for (const std::size_t count : {0, 1, 3}) {
                const std::size_t factors = model == ShadingModel::Flat ? 0 : count;
                keys.push_back(
                    shading_program(model, shows_environment, 1 + count, count == 1 ? 2 : 1,
                                    {{Blend::SurfaceColour, count},
                                     {Blend::SurfaceFactor, count},
                                     {Blend::AmbientLight, factors},
                                     {Blend::DirectLight, std::min<std::size_t>(1, factors)},
                                     {Blend::Overlay, count}}));
                if (count == 0)
                    keys.push_back(shading_program(model, shows_environment, 1, 1, {}, true));
            }
    return keys;
}

} // namespace isocast
