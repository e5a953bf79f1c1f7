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
#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <stdexcept>

namespace isocast {

namespace {

/// The active pages' ranges of samples become those of another field of control samples.
BlockRanges with_samples_of(const FieldSource& control, BlockRanges ranges,
                            const std::vector<ActivePage>& active) {
    tbb::parallel_for(std::size_t{0}, active.size(), [&](std::size_t i) {
        BlockPage& page = ranges.pages[active[i].page];
        const Index3 lo = (page_size * page.coordinate.array() - filter_support_below).matrix();
        std::vector<float> values(in_page(0, 0, page_samples));
        control.copy_box({lo, (lo.array() + page_samples).matrix()}, 0, values);
        const auto [min, max] = std::ranges::minmax(values);
        page.samples = {min, max};
    });
    return ranges;
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
}

} // namespace

Renderer::Renderer(gl::Context& context, const std::filesystem::path& shader_folder)
    : context_(context), shaders_({shader_folder}),
      no_vertices_(gl::VertexArray::without_attributes("no vertices")) {}

void Renderer::load(Scene scene, const Progress& progress) {
    if (!scene.field) throw InputError("the scene has no field");
    if (scene.quality.rate && scene.quality.rate_factor < 1)
        throw InputError("the factor between two sampling rates must be at least 1");
    if (scene.storage.fetch == Fetch::Linear && kernel_of(scene.filter) == Kernel::CatmullRom)
        throw InputError(fmt::format("linear fetches need weights of one sign, which the filter {} "
                                     "does not have: fetch rows or samples",
                                     filter_name(scene.filter)));
    if (scene.storage.over_budget == OverBudget::Coarsen &&
        (scene.storage.fetch == Fetch::Linear ||
         scene.derivative_filter.value_or(scene.filter) != scene.filter))
        throw InputError("coarse bricks cannot be fetched linearly, nor have a derivative filter");
    check_look(scene.look);
    // The old field goes first, so that both are never in memory.
    field_ = {};
    moving_.reset();
    derivative_field_ = {};
    derivative_control_ = {};
    control_ = control_samples(scene.field, scene.filter, progress);
    if (const Filter derivative_filter = scene.derivative_filter.value_or(scene.filter);
        !share_control_samples(scene.filter, derivative_filter))
        derivative_control_ = control_samples(scene.field, derivative_filter, progress);
    ranges_ = find_block_ranges(*control_, kernel_of(scene.filter), progress);
    coarse_.reset();
    scene_ = std::move(scene);
    look_textures_ = {};
    const float iso = static_cast<float>(scene_.iso_world);
    active_ = active_pages(ranges_, iso);
    active_ = active_pages(ranges_, iso, error_of_storage());
    if (scene_.storage.over_budget == OverBudget::Coarsen)
        coarse_ = coarsen(control_, kernel_of(scene_.filter), ranges_, active_, iso, scene_.storage,
                          progress);
    if (coarse_) control_ = coarse_->field;
    upload(progress);
}

void Renderer::set_look(Look look) {
    check_look(look);
    scene_.look = std::move(look);
    look_textures_ = {};
}

void Renderer::set_iso(double iso_world) {
    if (!control_) throw std::logic_error("no scene is loaded");
    if (scene_.storage.over_budget == OverBudget::Coarsen) { // ranges depend on what is coarse
        Scene scene = scene_;
        scene.iso_world = iso_world;
        load(std::move(scene));
        return;
    }
    if (!moving_)
        moving_.emplace(ranges_, static_cast<float>(scene_.iso_world), error_of_storage());
    scene_.iso_world = iso_world;
    const float iso = static_cast<float>(iso_world);
    moving_->move_to(iso);
    active_ = moving_->pages();
    if (const float error = error_of_storage(); error > 0) {
        moving_->move_to(iso, error);
        active_ = moving_->pages();
    }
    upload({});
}

float Renderer::error_of_storage() const {
    return storage_error(ranges_, active_, static_cast<float>(scene_.iso_world),
                         scene_.storage.format);
}

void Renderer::upload(const Progress& progress) {
    surface_box_.reset();
    field_ = {};
    derivative_field_ = {};
    const float iso = static_cast<float>(scene_.iso_world);
    StorageOptions storage = scene_.storage;
    if (derivative_control_) storage.budget_bytes /= 2;
    field_ = FieldOnGpu(*scene_.field, *control_, kernel_of(scene_.filter), ranges_, active_, iso,
                        storage, progress, scene_.quality.traversal, coarse_ ? &*coarse_ : nullptr);
    if (derivative_control_) {
        derivative_ranges_ = with_samples_of(*derivative_control_, ranges_, active_);
        derivative_field_ =
            FieldOnGpu(*scene_.field, *derivative_control_, kernel_of(*scene_.derivative_filter),
                       derivative_ranges_, active_, iso, storage, progress);
    }
    // Refining a sampled hit reads the block before as well, which may be gone by then; and only a
    // place in a list is kept from pass to pass.
    const bool can_stream =
        !scene_.quality.rate && scene_.quality.traversal == Traversal::TileLists;
    if (!can_stream && !field_.pool().holds_all())
        throw ResourceError(
            "all bricks must fit the texture budget for sampling at a rate, and for "
            "other ways to the blocks than lists");
    context_.throw_pending_error();
}

Traversal traversal_from_name(std::string_view name) {
    if (name == "lists") return Traversal::TileLists;
    if (name == "drawn") return Traversal::DrawnBlocks;
    if (name == "bounds") return Traversal::BoundingFaces;
    if (name == "walk") return Traversal::Walk;
    throw InputError(fmt::format("'{}' is not one of lists, drawn, bounds, walk", name));
}

const IndexBox& Renderer::surface_box() const {
    if (!surface_box_)
        surface_box_ =
            find_surface_box(*control_, ranges_, active_, static_cast<float>(scene_.iso_world));
    return *surface_box_;
}

std::array<Vec3d, 8> Renderer::surface_box_world() const {
    const IndexBox box = has_surface() ? surface_box() : scene_.field->extent();
    std::array<Vec3d, 8> corners;
    for (int i = 0; i < 8; ++i)
        corners[static_cast<std::size_t>(i)] = scene_.field->space().to_world(
            Vec3d(i & 1 ? box.hi.x() - 1 : box.lo.x(), i & 2 ? box.hi.y() - 1 : box.lo.y(),
                  i & 4 ? box.hi.z() - 1 : box.lo.z()));
    return corners;
}

FrameReport Renderer::draw(const Camera& camera, int width, int height, const ImageSet& wanted) {
    const int limit = gl::max_image_extent();
    if (width < 1 || height < 1 || width > limit || height > limit)
        throw InputError(fmt::format("picture size {}x{}: each side must lie between 1 and {}",
                                     width, height, limit));
    const PlacesOnGpu places(scene_.quality.traversal, ranges_, active_, scene_.field->space(),
                             camera, width, height);
    const bool has_derivative_field = derivative_field_.byte_count() > 0;
    FrameReport report;
    FrameContext frame{shaders_,
                       no_vertices_,
                       scene_,
                       field_,
                       has_derivative_field ? derivative_field_ : field_,
                       places,
                       camera,
                       width,
                       height,
                       targets_,
                       look_textures_};
    const std::vector<Pass> declared = declare_passes(frame);
    const std::vector<Pass> live = live_passes(declared, wanted);
    frame.has_fused_gradient =
        can_fuse_gradient(frame) && std::ranges::any_of(live, [](const Pass& pass) {
            return pass.writes == FrameImage::Gradient;
        });

    for (const Pass& pass : declared) {
        gl::Texture& texture = targets_.texture(pass.writes);
        const bool is_live =
            std::ranges::any_of(live, [&](const Pass& other) { return other.name == pass.name; });
        if (!is_live) {
            if (!texture.is_empty()) targets_.hit_and_gradient = {};
            targets_.framebuffer(pass.writes) = {};
            texture = {};
        } else if (texture.is_empty() || texture.width() != width || texture.height() != height) {
            targets_.hit_and_gradient = {};
            targets_.framebuffer(pass.writes) = {};
            texture = {};
            texture =
                gl::Texture::image(format_of(pass.writes), width, height, name_of(pass.writes));
            targets_.framebuffer(pass.writes) = gl::Framebuffer({&texture}, name_of(pass.writes));
        }
        const bool is_fused = frame.has_fused_gradient && pass.writes == FrameImage::Gradient;
        report.passes.push_back({std::string(pass.name), is_live, asked_by(pass, live, wanted),
                                 is_fused ? "raycast" : "", 0, texture.byte_count()});
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
    report.field_bytes = field_.byte_count() + derivative_field_.byte_count();
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
