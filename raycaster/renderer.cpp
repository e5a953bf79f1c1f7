// SPDX-License-Identifier: MPL-2.0
#include "raycaster/renderer.h"

#include "gl/timer.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <algorithm>
#include <map>
#include <stdexcept>

namespace isocast {

Renderer::Renderer(gl::Context& context, const std::filesystem::path& shader_folder)
    : context_(context), shaders_({shader_folder}),
      no_vertices_(gl::VertexArray::without_attributes("no vertices")) {}

void Renderer::load(Scene scene, const Progress& progress) {
    if (!scene.field) throw InputError("the scene has no field");
    const float iso = static_cast<float>(scene.iso_world);
    if (scene.quality.rate && scene.quality.rate_factor < 1)
        throw InputError("the factor between two sampling rates must be at least 1");
    // The old field goes first, so that both are never in memory.
    field_ = {};
    control_ = control_samples(scene.field, scene.filter, progress);
    ranges_ = find_block_ranges(*control_, kernel_of(scene.filter), progress);
    active_ = active_pages(ranges_, iso);
    active_ =
        active_pages(ranges_, iso, storage_error(ranges_, active_, iso, scene.storage.format));
    coarse_.reset();
    if (scene.storage.over_budget == OverBudget::Coarsen)
        coarse_ = coarsen(control_, kernel_of(scene.filter), ranges_, active_, iso, scene.storage,
                          progress);
    if (coarse_) control_ = coarse_->field;
    field_ = FieldOnGpu(*scene.field, *control_, kernel_of(scene.filter), ranges_, active_, iso,
                        scene.storage, progress, coarse_ ? &*coarse_ : nullptr);
    // Refining a hit reads the block before as well, which may be gone by then.
    if (scene.quality.rate && !field_.pool().holds_all())
        throw ResourceError("sampling at a rate needs all bricks in the texture budget");
    surface_box_ = find_surface_box(*control_, ranges_, active_, iso);
    scene_ = std::move(scene);
    context_.throw_pending_error();
}

std::array<Vec3d, 8> Renderer::surface_box_world() const {
    const IndexBox box = has_surface() ? surface_box_ : scene_.field->extent();
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
    const TilesOnGpu tiles(
        list_blocks(ranges_, active_, scene_.field->space(), camera, width, height));
    FrameContext frame{shaders_, no_vertices_, scene_, field_,  tiles,
                       camera,   width,        height, targets_};
    const std::vector<Pass> declared = declare_passes(frame);
    const std::vector<Pass> live = live_passes(declared, wanted);

    FrameReport report;
    for (const Pass& pass : declared) {
        gl::Texture& texture = targets_.texture(pass.writes);
        const bool is_live =
            std::ranges::any_of(live, [&](const Pass& other) { return other.name == pass.name; });
        if (!is_live) {
            targets_.framebuffer(pass.writes) = {};
            texture = {};
        } else if (texture.is_empty() || texture.width() != width || texture.height() != height) {
            targets_.framebuffer(pass.writes) = {};
            texture = {};
            texture =
                gl::Texture::image(format_of(pass.writes), width, height, name_of(pass.writes));
            targets_.framebuffer(pass.writes) = gl::Framebuffer({&texture}, name_of(pass.writes));
        }
        report.passes.push_back({std::string(pass.name), is_live, asked_by(pass, live, wanted), 0,
                                 texture.byte_count()});
        report.image_bytes += texture.byte_count();
    }

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
    report.field_bytes = field_.byte_count();
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
