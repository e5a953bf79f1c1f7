// SPDX-License-Identifier: MPL-2.0
#include "raycaster/renderer.h"

#include "gl/timer.h"
#include "raycaster/effects/effects.h"
#include "raycaster/field_passes.h"
#include "raycaster/passes.h"
#include "raycaster/shading.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <algorithm>
#include <map>
#include <stdexcept>

namespace isocast {

namespace {

/// throws  InputError
void check_look(const Look& look) {
    if (look.lights.size() > max_light_count)
        throw InputError(fmt::format("{} lights: {} at most", look.lights.size(), max_light_count));
    if (std::ranges::count_if(look.lights,
                              [](const Light& light) { return light.shadow != Shadow::None; }) > 1)
        throw InputError("one light at most casts shadows");
    for (const Layer& layer : layers_of(look))
        if (!(layer.strength >= 0 && layer.strength <= 1))
            throw InputError(fmt::format("{}: its strength {} does not lie between 0 and 1",
                                         name_of(layer.image), layer.strength));
    check_solid_texture(look.effects.solid_texture);
    if (look.environment.kind == Environment::Kind::Picture &&
        look.environment.picture.rgba.empty())
        throw InputError("environment: it has no picture");
}

} // namespace

Renderer::Renderer(gl::Context& context, const std::filesystem::path& shader_folder)
    : context_(context), shaders_({shader_folder}),
      no_vertices_(gl::VertexArray::without_attributes("no vertices")) {}

void Renderer::load(Scene scene, const Progress& progress) {
    const std::vector<FieldObject> objects = objects_of(scene);
    if (scene.quality.rate && scene.quality.rate_factor < 1)
        throw InputError("the factor between two sampling rates must be at least 1");
    if (is_composed(scene) &&
        (scene.quality.rate || scene.quality.traversal != Traversal::TileLists))
        throw InputError("composed objects are searched by certified steps through lists of "
                         "blocks, not at a rate or by other traversals");
    check_look(scene.look);
    // The old fields go first, so that both are never in memory.
    objects_.clear();
    objects_ = std::vector<LoadedObject>(objects.size());
    scene_ = std::move(scene);
    look_textures_ = {};
    StorageOptions storage = scene_.storage;
    storage.budget_bytes /= std::ssize(objects);
    for (std::size_t i = 0; i < objects.size(); ++i)
        objects_[i].load(objects[i], storage, scene_.quality.traversal, progress);
    check_residence();
}

void Renderer::set_look(Look look) {
    check_look(look);
    scene_.look = std::move(look);
    look_textures_ = {};
}

void Renderer::set_iso(double iso_world, int object) {
    LoadedObject& moved = objects_.at(static_cast<std::size_t>(object));
    if (!moved.is_loaded()) throw std::logic_error("no scene is loaded");
    moved.set_iso(iso_world);
    (scene_.field ? scene_.iso_world : scene_.objects[static_cast<std::size_t>(object)].iso_world) =
        iso_world;
    check_residence();
}

void Renderer::check_residence() {
    // Refining a sampled hit reads the block before as well, which may be gone by then; and only a
    // place in a list is kept from pass to pass.
    const bool can_stream = !scene_.quality.rate &&
                            scene_.quality.traversal == Traversal::TileLists &&
                            !is_composed(scene_);
    for (const LoadedObject& object : objects_)
        if (!can_stream && !object.field().pool().holds_all())
            throw ResourceError(
                "all bricks must fit the texture budget for sampling at a rate, for other ways to "
                "the blocks than lists, and for composed objects, each in an equal share");
    context_.throw_pending_error();
}

Eigen::AlignedBox3d Renderer::composed_box() const {
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const LoadedObject& object : objects_) {
        boxes.push_back(world_box(object.surface_box(), object.object().field->space()));
    }
    using Box = Eigen::AlignedBox3d;
    return evaluate(
        tree_of(scene_), std::span<const Box>(boxes),
        [](const Box& a, const Box& b) { return a.merged(b); },
        [](const Box& a, const Box& b) { return a.intersection(b); },
        [](const Box& a, const Box&) { return a; });
}

bool Renderer::has_surface() const {
    return is_composed(scene_) ? !composed_box().isEmpty() : !at(0).surface_box().is_empty();
}

std::array<Vec3d, 8> Renderer::surface_box_world() const {
    const FieldObject& first = at(0).object();
    if (!has_surface()) return corners_of(first.field->extent(), first.field->space());
    if (!is_composed(scene_)) return corners_of(at(0).surface_box(), first.field->space());
    const Eigen::AlignedBox3d box = composed_box();
    std::array<Vec3d, 8> corners;
    for (int i = 0; i < 8; ++i)
        corners[static_cast<std::size_t>(i)] =
            box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    return corners;
}

FrameReport Renderer::draw(const Camera& camera, int width, int height, const ImageSet& wanted) {
    const int limit = gl::max_image_extent();
    if (width < 1 || height < 1 || width > limit || height > limit)
        throw InputError(fmt::format("picture size {}x{}: each side must lie between 1 and {}",
                                     width, height, limit));
    std::vector<FrameObject> objects;
    for (LoadedObject& object : objects_)
        objects.push_back({object.object(),
                           object.field(),
                           object.derivative_field(),
                           {scene_.quality.traversal, object.ranges(), object.active(),
                            object.object().field->space(), camera, width, height},
                           object.box_world()});
    const PlacesOnGpu places_of_all =
        is_composed(scene_) ? union_of_places(objects, width, height) : PlacesOnGpu();
    const FrameObject& first = objects.front();
    FrameReport report;
    FrameContext frame{shaders_,
                       no_vertices_,
                       scene_,
                       first.object,
                       first.field,
                       first.derivative_field,
                       is_composed(scene_) ? places_of_all : first.places,
                       camera,
                       width,
                       height,
                       targets_,
                       look_textures_,
                       objects};
    const std::vector<Pass> declared = declare_passes(frame);
    const std::vector<Pass> live = live_passes(declared, wanted);
    for (const Pass& pass : live) frame.live.insert(pass.writes);
    frame.has_fused_gradient =
        can_fuse_gradient(frame) && frame.live.contains(FrameImage::Gradient);

    for (const Pass& pass : declared) {
        gl::Texture& texture = targets_.texture(pass.writes);
        const bool is_live = frame.live.contains(pass.writes);
        if (!is_live) {
            if (!texture.is_empty()) targets_.hit_and_gradient = {};
            targets_.framebuffer(pass.writes) = {};
            texture = {};
        } else if (texture.is_empty() || texture.width() != width || texture.height() != height) {
            targets_.hit_and_gradient = {};
            targets_.framebuffer(pass.writes) = {};
            texture = {};
            texture = gl::Texture::image(format_of(pass.writes), width, height,
                                         name_of(pass.writes), filter_of(pass.writes));
            targets_.framebuffer(pass.writes) = gl::Framebuffer({&texture}, name_of(pass.writes));
        }
        const auto drawer =
            std::ranges::find(declared, drawn_with(frame, pass.writes), &Pass::writes);
        report.passes.push_back(
            {std::string(pass.name), is_live, asked_by(pass, live, wanted),
             is_live && drawer->name != pass.name ? std::string(drawer->name) : "", 0,
             texture.byte_count()});
        report.image_bytes += texture.byte_count();
    }
    if (frame.has_fused_gradient && targets_.hit_and_gradient.id() == 0)
        targets_.hit_and_gradient = gl::Framebuffer(
            {&targets_.texture(FrameImage::Hit), &targets_.texture(FrameImage::Gradient)},
            "hit and gradient");

    std::map<std::string_view, gl::Timer> timers;
    for (const Pass& pass : live) {
        const gl::DebugGroup group(pass.name);
        gl::Timer& timer = timers[pass.name];
        timer.start();
        pass.run();
        timer.stop();
        context_.throw_pending_error();
    }
    for (PassReport& pass : report.passes)
        if (pass.ran) pass.milliseconds = timers.at(pass.name).milliseconds();
    report.programs_compiled = shaders_.compiled_program_count();
    for (const LoadedObject& object : objects_) report.field_bytes += object.byte_count();
    report.scratch_bytes = frame.scratch_bytes;
    report.notes = std::move(frame.notes);
    report.look_bytes = look_textures_.byte_count();
    return report;
}

Image Renderer::read(FrameImage image) const {
    const gl::Texture& texture = targets_.textures[static_cast<std::size_t>(image)];
    if (texture.is_empty())
        throw std::logic_error(fmt::format("image '{}' was not drawn", name_of(image)));
    Image out{texture.width(), texture.height(), {}};
    const auto row = static_cast<std::size_t>(out.width) * 4;
    std::vector<float> bottom_up(row * static_cast<std::size_t>(out.height));
    texture.read_rgba(bottom_up);
    out.rgba.resize(bottom_up.size());
    for (std::size_t y = 0; y < static_cast<std::size_t>(out.height); ++y)
        std::copy_n(bottom_up.data() + (static_cast<std::size_t>(out.height) - 1 - y) * row, row,
                    out.rgba.data() + y * row);
    context_.throw_pending_error();
    return out;
}

} // namespace isocast
