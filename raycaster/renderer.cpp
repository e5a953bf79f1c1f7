// SPDX-License-Identifier: MPL-2.0
#include "raycaster/renderer.h"

#include "filtering/smoothed_field.h"
#include "gl/timer.h"
#include "raycaster/direct_passes.h"
#include "raycaster/effects/effects.h"
#include "raycaster/effects/flow.h"
#include "raycaster/effects/shadow.h"
#include "raycaster/field_passes.h"
#include "raycaster/look_changes.h"
#include "raycaster/passes.h"
#include "raycaster/shading.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

namespace isocast {

namespace {

constexpr int least_shadow_map = 16;     // pixels: of which four are its empty border
constexpr int default_shadow_map = 4096; // at most: its hits are 256 MiB while they are cast

bool has_primitives(const Scene& scene) {
    return scene.primitives && scene.primitives->count() > 0;
}

/// throws  InputError
void check_quality(const Quality& quality, bool is_composed) {
    if (quality.rate && quality.rate_factor < 1)
        throw InputError("the factor between two sampling rates must be at least 1");
    if (is_composed && (quality.rate || quality.traversal != Traversal::TileLists))
        throw InputError("composed objects are searched by certified steps through lists of "
                         "blocks, not at a rate or by other traversals");
    if (!(quality.detail_pixels >= 0 && quality.detail_pixels <= 4))
        throw InputError(
            fmt::format("details of {} pixels: not in 0 ... 4", quality.detail_pixels));
}

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
    check_colour_effects(look.effects);
    if (look.environment.kind == Environment::Kind::Picture &&
        look.environment.picture.rgba.empty())
        throw InputError("environment: it has no picture");
    if (const Light* light = casting_light(look)) {
        if (!(light->direction.norm() > 0) || !light->direction.allFinite())
            throw InputError("a light that casts shadows needs a direction");
        if (!(light->size_degrees >= 0 && light->size_degrees < 180))
            throw InputError(
                fmt::format("a light of {} degrees: not in [0, 180)", light->size_degrees));
        const int pixels = light->shadow_map_pixels.value_or(least_shadow_map);
        if (pixels < least_shadow_map || pixels > gl::max_image_extent())
            throw InputError(fmt::format("a shadow map of {} pixels: not in {} ... {}", pixels,
                                         least_shadow_map, gl::max_image_extent()));
    }
    const Occlusion& occlusion = look.effects.occlusion;
    if (occlusion.rays < 1)
        throw InputError(fmt::format("{} rays for ambient occlusion: 1 at least", occlusion.rays));
    if (occlusion.distance_world && !(*occlusion.distance_world > 0))
        throw InputError("the distance of occluders must be positive");
    check(look.effects.flow);
}

/// Those of a picture's images that need not be drawn again.
///
/// drawn  that still hold, but for what they are made of
ImageSet images_kept(const std::vector<Pass>& live, ImageSet drawn, bool keeps_shadow_map) {
    const auto is_live = [&](FrameImage image) {
        return std::ranges::find(live, image, &Pass::writes) != live.end();
    };
    const auto are_drawn = [&](const auto& is_of_group) {
        return std::ranges::all_of(live, [&](const Pass& pass) {
            return !is_of_group(pass.writes) || drawn.contains(pass.writes);
        });
    };
    // What one pass draws with another it draws for all or for none.
    const auto is_drawn_with_hits = [](FrameImage image) {
        return image == FrameImage::Hit || image == FrameImage::Steps ||
               image == FrameImage::SplatColour;
    };
    if (is_live(FrameImage::Hit) && !are_drawn(is_drawn_with_hits)) drawn.erase(FrameImage::Hit);
    const bool has_second_order = are_drawn(is_of_second_order);
    ImageSet kept;
    for (const Pass& pass : live) {
        const bool is_drawn = pass.writes == FrameImage::ShadowMap ? keeps_shadow_map
                              : is_of_second_order(pass.writes)    ? has_second_order
                                                                   : drawn.contains(pass.writes);
        if (is_drawn && kept.contains(pass.reads)) kept.insert(pass.writes);
    }
    return kept;
}

} // namespace

Renderer::Renderer(gl::Context& context, const std::filesystem::path& shader_folder)
    : context_(context), shaders_({shader_folder}),
      no_vertices_(gl::VertexArray::without_attributes("no vertices")) {}

void Renderer::load(Scene scene, const Progress& progress) {
    const std::vector<FieldObject> objects = objects_of(scene);
    check_quality(scene.quality, is_composed(scene));
    if (!(scene.curvature_scale_voxels >= 0 &&
          scene.curvature_scale_voxels <= greatest_scale_voxels))
        throw InputError(fmt::format("a curvature scale of {} voxels: it must lie between 0 and {}",
                                     scene.curvature_scale_voxels, greatest_scale_voxels));
    if (scene.storage.over_budget == OverBudget::Coarsen && scene.curvature_scale_voxels > 0)
        throw InputError("coarse bricks cannot have curvatures at a scale");
    check_look(scene.look);
    check_slice(scene.look.effects.slice, objects);
    if (scene.quality.splats == SplatShading::Direct)
        check_direct(scene.look, !objects.empty(),
                     scene.primitives && !scene.primitives->slims.empty());
    if (scene.primitives) check(*scene.primitives);
    check(scene.cut);
    StorageOptions storage = scene.storage;
    storage.budget_bytes /= std::max<std::ptrdiff_t>(std::ssize(objects), 1);
    // What stays the same is kept; other old fields go first, so that they and the new ones are
    // never in memory together.
    std::vector<std::unique_ptr<LoadedObject>> loaded;
    for (const FieldObject& object : objects) {
        const auto found = std::ranges::find_if(objects_, [&](const auto& old) {
            return old && old->takes(object, storage, scene.quality.traversal,
                                     scene.curvature_scale_voxels);
        });
        loaded.push_back(found == objects_.end() ? nullptr : std::move(*found));
    }
    forget_parts();
    objects_.clear();
    for (std::size_t i = 0; i < objects.size(); ++i) {
        if (loaded[i]) continue;
        loaded[i] = std::make_unique<LoadedObject>();
        loaded[i]->load(objects[i], storage, scene.quality.traversal, scene.curvature_scale_voxels,
                        progress);
    }
    objects_ = std::move(loaded);
    scene_ = std::move(scene);
    primitives_on_gpu_ = {};
    primitives_ = scene_.primitives;
    primitives_box_ = {};
    if (has_primitives(scene_)) {
        const Primitives& some = *scene_.primitives;
        primitives_on_gpu_ = PrimitivesOnGpu(
            some.dots.empty() ? some : with_dots_as_spheres(some, {}, 1)); // however large
        primitives_box_ = box_of(some);
    }
    look_textures_ = {};
    look_numbers_ = {};
    check_residence();
}

void Renderer::set_look(Look look) {
    check_look(look);
    if (look.effects.slice.strength > 0) check_slice(look.effects.slice, objects_of(scene_));
    if (scene_.quality.splats == SplatShading::Direct)
        check_direct(look, !objects_.empty(), !scene_.primitives->slims.empty());
    const ImageSet changed = images_changed(scene_.look, look);
    for (DrawnPart& part : parts_) part.drawn.erase(changed);
    const Effects& old = scene_.look.effects;
    const Effects& now = look.effects;
    if (scene_.look.environment != look.environment || old.curvature_map != now.curvature_map ||
        old.curvature_colour != now.curvature_colour || old.solid_texture != now.solid_texture ||
        old.slice.normal != now.slice.normal || old.slice.offset_world != now.slice.offset_world)
        look_textures_ = {};
    scene_.look = std::move(look);
}

void Renderer::set_quality(const Quality& quality) {
    check_quality(quality, is_composed(scene_));
    if (quality.traversal != scene_.quality.traversal || quality.splats != scene_.quality.splats)
        throw std::logic_error("another traversal or shading of splats needs a new load");
    const Quality before = std::exchange(scene_.quality, quality);
    try {
        check_residence();
    } catch (...) {
        scene_.quality = before;
        throw;
    }
}

void Renderer::keep_parts(std::size_t count) {
    kept_part_count_ = count;
    forget_parts();
}

void Renderer::set_study(const SplatStudy& study) {
    study_ = study;
    forget_parts();
}

void Renderer::set_iso(double iso_world, int object) {
    objects_.at(static_cast<std::size_t>(object))->set_iso(iso_world);
    (scene_.field ? scene_.iso_world : scene_.objects[static_cast<std::size_t>(object)].iso_world) =
        iso_world;
    check_residence();
}

void Renderer::set_isos(const std::vector<FieldObject>& objects) {
    for (std::size_t i = 0; i < objects.size(); ++i)
        if (objects[i].iso_world != objects_.at(i)->object().iso_world)
            set_iso(objects[i].iso_world, static_cast<int>(i));
}

void Renderer::set_look_numbers(LookNumbers numbers) {
    look_numbers_ = std::move(numbers);
    std::erase_if(look_numbers_, [](const auto& found) { return !found.second.value; });
    for (DrawnPart& part : parts_) part.drawn = {};
}

void Renderer::forget_parts() {
    parts_.clear();
    shadow_map_.reset(); // it was the last part's
}

void Renderer::check_residence() {
    forget_parts();                             // they were of another surface, or found otherwise
    set_look_numbers(std::move(look_numbers_)); // what the surface did not have it may have now
    // Refining a sampled hit reads the block before as well, which may be gone by then; and only a
    // place in a list is kept from pass to pass.
    const bool can_stream = !scene_.quality.rate &&
                            scene_.quality.traversal == Traversal::TileLists &&
                            !is_composed(scene_) && !has_primitives(scene_);
    for (const auto& object : objects_)
        if (!can_stream && !object->field().pool().holds_all())
            throw ResourceError(
                "all bricks must fit the texture budget for sampling at a rate, for other ways to "
                "the blocks than lists, for composed objects, each in an equal share, and beside "
                "primitives");
    context_.throw_pending_error();
}

ShownSurfaces Renderer::shown() const {
    ShownSurfaces shown{scene_, {}, primitives_box_};
    for (const auto& object : objects_) shown.boxes.push_back(object->surface_box());
    return shown;
}

bool Renderer::has_surface() const {
    return shown().is_any();
}

std::array<Vec3d, 8> Renderer::surface_box_world() const {
    return shown().box_world();
}

std::vector<Vec3d> Renderer::surface_points_world() const {
    return shown().points_world();
}

SeenScene Renderer::seen_by(const Camera& camera, int width, int height, const PicturePart& part,
                            double detail_pixels) {
    SeenScene seen;
    std::vector<std::vector<Eigen::Vector4i>> runs;
    for (const auto& object : objects_) {
        const FieldSource& field = *object->object().field;
        seen.objects.push_back({object->object(),
                                object->field(),
                                object->derivative_field(),
                                object->curvature_field(),
                                {scene_.quality.traversal, object->ranges(), object->active(),
                                 field.space(), camera, width, height, part},
                                object->box_world()});
        seen.extents_world.push_back(corners_of(field.extent(), field.space()));
        runs.push_back(seen.objects.back().places.tile_runs);
    }
    if (has_primitives(scene_)) {
        seen.splats.emplace(*primitives_, cut_planes_, camera, width, height, part, detail_pixels,
                            study_);
        seen.splats->of_scene = &primitives_on_gpu_;
        seen.extents_world.push_back(corners_of(primitives_box_));
        runs.push_back(seen.splats->tile_runs);
    }
    if (!seen.has_one_object())
        seen.places_of_all.set_runs(union_of_runs(runs, part.width, part.height));
    return seen;
}

FrameReport Renderer::draw(const Camera& camera, int width, int height, const ImageSet& wanted,
                           const std::optional<PicturePart>& asked_part) {
    const auto check_size = [](const char* what, int w, int h, int limit) {
        if (w < 1 || h < 1 || w > limit || h > limit)
            throw InputError(
                fmt::format("{} {}x{}: each side must lie between 1 and {}", what, w, h, limit));
    };
    check_size("picture size", width, height, max_picture_extent);
    const PicturePart part = asked_part.value_or(PicturePart{.width = width, .height = height});
    check_size("drawn at a time:", part.width, part.height, gl::max_image_extent());
    if (objects_.empty() && !has_primitives(scene_)) throw std::logic_error("no scene is loaded");
    if (has_primitives(scene_) && !scene_.primitives->dots.empty()) {
        primitives_ = std::make_shared<Primitives>(with_dots_as_spheres(
            *scene_.primitives, picture_space(camera), pixels_per_unit(camera, height)));
        primitives_box_ = box_of(*primitives_);
        forget_parts();
    }
    if (std::vector<CutPlane> planes = planes_of(scene_.cut, camera); planes != cut_planes_) {
        cut_planes_ = std::move(planes);
        forget_parts();
    }
    DrawnPart& drawn = part_of(camera, width, height, part);
    if (!drawn.seen)
        drawn.seen.emplace(seen_by(camera, width, height, part, scene_.quality.detail_pixels));
    const SeenScene& seen = *drawn.seen;
    FrameTargets& targets = drawn.targets;
    FrameReport report;
    FrameContext frame{shaders_,
                       no_vertices_,
                       scene_,
                       seen,
                       seen.objects.empty() ? nullptr : &seen.objects.front(),
                       seen.places(),
                       camera,
                       width,
                       height,
                       targets,
                       look_textures_,
                       look_numbers_,
                       part};
    if (has_primitives(scene_)) frame.primitives = primitives_.get();
    const std::vector<Pass> declared = declare_passes(frame);
    const std::vector<Pass> live = live_passes(declared, wanted);
    const auto is_live = [&](FrameImage image) { return frame.live.contains(image); };
    for (const Pass& pass : live) frame.live.insert(pass.writes);
    frame.surface_box_world = [&] { return surface_box_world(); };
    frame.see = [&](const Camera& other, int other_width, int other_height) {
        return seen_by(other, other_width, other_height,
                       {.width = other_width, .height = other_height}, 0);
    };
    if (is_live(FrameImage::ShadowMap)) {
        const Light* light = casting_light(scene_.look);
        if (light == nullptr) throw InputError("no light casts shadows");
        // The surface is within a voxel of the control samples that enclose it.
        double margin_world = 0;
        for (const auto& object : objects_)
            margin_world = std::max(margin_world, object->object()
                                                      .field->space()
                                                      .world_from_index.linear()
                                                      .colwise()
                                                      .norm()
                                                      .maxCoeff());
        const int map_pixels = light->shadow_map_pixels.value_or(
            std::clamp(std::max(width, height), least_shadow_map, default_shadow_map));
        frame.light = light_view(*light, camera, map_pixels, surface_box_world(), margin_world);
        frame.notes.push_back(fmt::format("shadow map: {}x{} texels of {:.3g} world units",
                                          frame.light->width, frame.light->height,
                                          frame.light->texel_world));
    }
    const bool keeps_shadow_map = frame.light && frame.light == shadow_map_;
    if (!keeps_shadow_map) shadow_map_.reset();
    const ImageSet kept = images_kept(live, drawn.drawn, keeps_shadow_map);
    drawn.drawn = {}; // until all is drawn
    frame.has_fused_gradient = can_fuse_gradient(frame) && is_live(FrameImage::Gradient) &&
                               !kept.contains(FrameImage::Hit);

    const bool is_smoothed =
        scene_.curvature_scale_voxels > 0 &&
        std::ranges::any_of(live, [](const Pass& pass) { return is_of_second_order(pass.writes); });
    for (const auto& object : objects_) object->keep_smoothed(is_smoothed);

    for (const Pass& pass : declared) {
        gl::Texture& texture = targets.texture(pass.writes);
        const bool is_of_light = frame.light && pass.writes == FrameImage::ShadowMap;
        const int image_width = is_of_light ? frame.light->width : part.width;
        const int image_height = is_of_light ? frame.light->height : part.height;
        if (!is_live(pass.writes)) {
            targets.framebuffer(pass.writes) = {};
            texture = {};
        } else if (texture.is_empty() || texture.width() != image_width ||
                   texture.height() != image_height) {
            targets.make(pass.writes, image_width, image_height);
        }
        const bool is_kept = is_live(pass.writes) && kept.contains(pass.writes);
        const auto drawer =
            std::ranges::find(declared, drawn_with(frame, pass.writes), &Pass::writes);
        const bool is_drawn_with_another = is_live(pass.writes) && drawer->name != pass.name;
        report.passes.push_back({.name = std::string(pass.name),
                                 .ran = is_live(pass.writes) && !is_kept,
                                 .asked_by = asked_by(pass, live, wanted),
                                 .drawn_by = is_drawn_with_another ? std::string(drawer->name) : "",
                                 .is_kept = is_kept,
                                 .texture_bytes = texture.byte_count()});
        report.image_bytes += texture.byte_count();
    }

    std::map<std::string_view, gl::Timer> timers;
    for (const Pass& pass : live) {
        if (kept.contains(pass.writes)) continue;
        const gl::DebugGroup group(pass.name);
        gl::Timer& timer = timers[pass.name];
        timer.start();
        pass.run();
        timer.stop();
        context_.throw_pending_error();
    }
    shadow_map_ = frame.light;
    if (kept_part_count_ > 0) drawn.drawn = frame.live;
    if (study_.counts_fragments && seen.splats) report.splat_fragments = count_fragments(frame);
    for (PassReport& pass : report.passes)
        if (pass.ran) pass.milliseconds = timers.at(pass.name).milliseconds();
    report.programs_compiled = shaders_.compiled_program_count();
    for (const auto& object : objects_) report.field_bytes += object->byte_count();
    if (seen.splats) report.splat_bytes = primitives_on_gpu_.byte_count() + seen.splats->byte_count;
    report.scratch_bytes = frame.scratch_bytes;
    report.notes = std::move(frame.notes);
    report.look_bytes = look_textures_.byte_count();
    if (kept_part_count_ == 0) drawn.seen.reset();
    return report;
}

Renderer::DrawnPart& Renderer::part_of(const Camera& camera, int width, int height,
                                       const PicturePart& part) {
    const auto is_of_picture = [&](const DrawnPart& other) {
        return other.camera == camera && other.width == width && other.height == height;
    };
    auto found = std::ranges::find_if(
        parts_, [&](const DrawnPart& other) { return is_of_picture(other) && other.part == part; });
    if (found == parts_.end()) {
        // Another sample of the same pixels, or else the oldest, gives its textures.
        std::erase_if(parts_, [&](const DrawnPart& other) {
            return &other != &parts_.back() && !is_of_picture(other);
        });
        found = std::ranges::find_if(parts_, [&](const DrawnPart& other) {
            const PicturePart& p = other.part;
            return p.x == part.x && p.y == part.y && p.width == part.width &&
                   p.height == part.height;
        });
        if (found == parts_.end() && parts_.size() >= std::max<std::size_t>(kept_part_count_, 1))
            found = parts_.begin();
        if (found == parts_.end()) found = parts_.emplace(parts_.begin());
        found->camera = camera;
        found->width = width;
        found->height = height;
        found->part = part;
        found->seen.reset();
        found->drawn = {};
    }
    // The shadow map is one for all.
    FrameTargets& last = parts_.back().targets;
    if (&last != &found->targets) {
        std::swap(found->targets.texture(FrameImage::ShadowMap),
                  last.texture(FrameImage::ShadowMap));
        std::swap(found->targets.framebuffer(FrameImage::ShadowMap),
                  last.framebuffer(FrameImage::ShadowMap));
    }
    std::rotate(found, found + 1, parts_.end());
    return parts_.back();
}

const gl::Texture& Renderer::texture(FrameImage image) const {
    if (parts_.empty() ||
        parts_.back().targets.textures[static_cast<std::size_t>(image)].is_empty())
        throw std::logic_error(fmt::format("image '{}' was not drawn", name_of(image)));
    return parts_.back().targets.textures[static_cast<std::size_t>(image)];
}

Image Renderer::read(FrameImage image) const {
    const gl::Texture& texture = this->texture(image);
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
