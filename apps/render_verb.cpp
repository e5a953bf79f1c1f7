// SPDX-License-Identifier: MPL-2.0
#include "apps/verbs.h"

#include "apps/accuracy/promise.h"
#include "apps/console.h"
#include "apps/output_words.h"
#include "apps/picture.h"
#include "apps/picture_file.h"
#include "apps/render_report.h"
#include "apps/scene_objects.h"
#include "apps/sequence.h"
#include "raycaster/reference_renderer.h"
#include "volume/errors.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>

namespace isocast {

namespace {

/// throws  UsageError, or InputError if the output cannot be written
void check_command(const RenderCommand& command, const SceneFile& scene) {
    const OutputSpec& output = scene.output;
    check_output(output.frames ? frame_path(command.output, output.frames->first) : command.output,
                 {".png", ".exr"});
    const std::string name = command.output.string();
    if (is_png(command.output) && output.layers)
        throw UsageError(
            fmt::format("--aov: {}: a PNG holds the picture only; write an .exr", name));
    if (!output.has_beauty && (is_png(command.output) || !output.layers))
        throw UsageError(
            fmt::format("--no-beauty: {}: an .exr with --aov is left, nothing else", name));
    if (command.reference && command.explain)
        throw UsageError("--explain: --reference draws without passes");
    if (command.reference && command.backend != gl::Backend::Auto)
        throw UsageError("--backend: --reference draws without OpenGL");
    if (scene.storage.over_budget == OverBudget::Coarsen &&
        kernel_of(scene.filter) != Kernel::BSpline)
        throw UsageError(fmt::format("--over-budget coarsen: only cubic B-splines can be coarsened "
                                     "(--filter interpolating, bspline, exact), not {}",
                                     filter_name(scene.filter)));
}

/// Of several objects each has its own, which end in its number.
///
/// driver  none of the reference
ExrImage exr_attributes(const RenderCommand& command, const Scene& scene,
                        const gl::DriverInfo* driver) {
    ExrImage exr;
    exr.strings = {{"source", command.input()},
                   driver ? std::pair{"glRenderer", driver->renderer}
                          : std::pair{"caster", std::string("double reference")}};
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const FieldObject& object = scene.objects[i];
        const std::string number = scene.objects.size() == 1 ? "" : std::to_string(i + 1);
        exr.floats["iso" + number] = static_cast<float>(object.iso_world);
        exr.floats["voxelSize" + number] =
            static_cast<float>(object.field->space().voxel_size_world());
        exr.strings["filter" + number] = filter_name(object.filter);
        if (object.derivative_filter)
            exr.strings["derivativeFilter" + number] = filter_name(*object.derivative_filter);
    }
    return exr;
}

PictureRequest request_of(const SceneFile& scene, const RenderCommand& command) {
    const OutputSpec& output = scene.output;
    PictureRequest request{.width = output.width,
                           .height = output.height,
                           .has_beauty = output.has_beauty,
                           .samples = output.samples,
                           .pixel_filter = output.pixel_filter,
                           .tile_pixels = output.tile_pixels,
                           .repeat = command.repeat};
    if (!is_png(command.output)) request.others = images_of(output.layers.value_or(ExrLayers{}));
    return request;
}

/// One run of the verb.
class Rendering {
public:
    Rendering(const RenderCommand& command, Console& console)
        : command_(command), console_(console), scene_(scene_of(command)) {
        check_command(command_, scene_);
        if (scene_.fetch) fetch_ = FetchChoice{*scene_.fetch, "asked for"};
    }

    void run(const std::vector<std::filesystem::path>& shader_folders) {
        // What is wrong with the input is said before OpenGL is tried, and that before the long
        // work.
        progress_("reading", 0);
        const SceneFile first = scene_at(scene_, 0, frames_.count());
        objects_.open(first);
        seconds_.field = step_.lap();
        if (!command_.reference) {
            context_ = gl::make_context({.backend = command_.backend});
            renderer_.emplace(*context_, first_folder_of(shader_folders));
        }
        seconds_.context = step_.lap();

        load(first);
        framed_world_ =
            renderer_ ? renderer_->surface_points_world() : reference_.shown().points_world();
        FrameReport frame;
        for (int i = 0; i < frames_.count(); ++i) {
            const SceneFile now = scene_at(scene_, i, frames_.count());
            if (i > 0) change_to(now);
            warn_if_nothing_is_seen();
            frame = draw(now, i);
        }
        seconds_.total = total_.seconds();
        console_.end_progress();
        report(frame);
    }

private:
    Scene composed(const SceneFile& now) {
        return objects_.compose(now, progress_,
                                [this](const std::string& warning) { warn(warning); });
    }

    void load(const SceneFile& now) {
        if (!renderer_) {
            load_reference(composed(now), now);
            return;
        }
        // Of the frame before: a series whose colours mean another thing in each would flicker.
        LookNumbers numbers = renderer_->look_numbers();
        loaded_ = composed(now);
        loaded_.look = look_of(now, is_opaque(now, command_.output));
        seconds_.field += step_.lap();
        if (!fetch_ && !loaded_.objects.empty())
            fetch_ = choose_fetch(*renderer_, context_->driver(), hardest_filter(loaded_),
                                  loaded_.storage);
        if (fetch_) loaded_.storage.fetch = fetch_->fetch;
        renderer_->load(loaded_, progress_);
        renderer_->set_look_numbers(std::move(numbers));
        seconds_.load += step_.lap();
        for (std::size_t i = 0; i < loaded_.objects.size(); ++i)
            if (const auto& coarse = renderer_->coarse_bricks(static_cast<int>(i));
                coarse && !renderer_->is_adapted(static_cast<int>(i)))
                warn(fmt::format(
                    "over the texture budget: {} of {} bricks were coarsened; the surface moves "
                    "by up to {:.2g} voxel where the field's slope is one",
                    coarse->coarse_count(), coarse->block_count(),
                    coarse->greatest_residual /
                        loaded_.objects[i].field->space().voxel_size_world()));
    }

    void load_reference(Scene scene, const SceneFile& now) {
        loaded_ = std::move(scene);
        loaded_.look = look_of(now, is_opaque(now, command_.output));
        seconds_.field += step_.lap();
        reference_.load(loaded_, progress_);
        seconds_.load += step_.lap();
    }

    /// What a frame after the first needs.
    void change_to(const SceneFile& now) {
        const Change change = change_of(scene_);
        if (!renderer_ && change > Change::Nothing) {
            objects_.open(now);
            load(now);
            return;
        }
        if (change == Change::Load) {
            objects_.open(now);
            load(now);
            return;
        }
        if (change >= Change::Look)
            renderer_->set_look(look_of(now, is_opaque(now, command_.output)));
        if (change < Change::Iso) return;
        const Scene moved = composed(now);
        renderer_->set_isos(moved.objects);
        loaded_.objects = moved.objects;
        seconds_.load += step_.lap();
    }

    FrameReport draw(const SceneFile& now, int i) {
        const double aspect = double(now.output.width) / now.output.height;
        const Camera camera =
            camera_at(now, camera_from(now.camera, framed_world_, aspect), i, frames_.count());
        const std::vector<PictureView> views = views_of(now, camera);
        PictureFile file(scene_.output.frames ? frame_path(command_.output, frames_.first + i)
                                              : command_.output,
                         now, views, exr_attributes(command_, loaded_, driver()));
        const FrameReport frame = draw_picture(
            renderer_ ? source_of(*renderer_) : reference_source(i), views,
            request_of(now, command_),
            [&](const std::vector<FrameImages>& rows) {
                seconds_.draw += step_.lap();
                file.write(rows);
                seconds_.write += step_.lap();
            },
            [&](std::string_view stage, double fraction) {
                progress_(stage, (i + fraction) / frames_.count());
            });
        file.finish();
        seconds_.write += step_.lap();
        return frame;
    }

    /// Of frame `i`.
    PictureSource reference_source(int i) {
        const Progress progress = [this, i](std::string_view stage, double fraction) {
            progress_(stage, (i + fraction) / frames_.count());
        };
        // 4096: parts of what memory has room for, as large as a GL's.
        return {4096, 0,
                [this, progress](const Camera& camera, int width, int height,
                                 const ImageSet& wanted, const PicturePart& part) {
                    return reference_.draw(camera, width, height, wanted, part, progress);
                },
                [this](FrameImage image) { return reference_.read(image); }};
    }

    /// None of the reference.
    const gl::DriverInfo* driver() const { return context_ ? &context_->driver() : nullptr; }

    void warn(const std::string& warning) {
        if (std::ranges::find(warnings_, warning) != warnings_.end()) return; // of another frame
        console_.warn(fmt::format("{}: {}", command_.input(), warning));
        warnings_.push_back(warning);
    }

    void warn_if_nothing_is_seen() {
        if (!(renderer_ ? renderer_->has_surface() : reference_.shown().is_any()))
            warn(why_nothing_is_seen(loaded_));
    }

    void report(const FrameReport& frame) const {
        const RenderReport report{.command = command_,
                                  .scene = scene_,
                                  .driver = driver(),
                                  .renderer = renderer_ ? &*renderer_ : nullptr,
                                  .fetch = fetch_,
                                  .loaded = loaded_,
                                  .frame_count = frames_.count(),
                                  .frame = frame,
                                  .warnings = warnings_,
                                  .seconds = seconds_};
        if (command_.json) {
            print_json(report);
            return;
        }
        if (command_.explain) explain(report);
        print(report);
    }

    const RenderCommand& command_;
    Console& console_;
    const Stopwatch total_;
    const SceneFile scene_;
    const FrameRange frames_ = scene_.output.frames.value_or(FrameRange{});
    const tbb::global_control threads_{tbb::global_control::max_allowed_parallelism,
                                       command_.threads};
    const Progress progress_ = console_.progress();
    std::vector<std::string> warnings_;
    RenderSeconds seconds_;
    Stopwatch step_;
    std::unique_ptr<gl::Context> context_;
    std::optional<Renderer> renderer_; // or else
    ReferenceRenderer reference_;
    std::optional<FetchChoice> fetch_;
    SceneObjects objects_;
    Scene loaded_;
    std::vector<Vec3d> framed_world_;
};

/// The cheapest setting that keeps the error which the command allows; says which.
void choose(RenderCommand& command, const std::vector<std::filesystem::path>& data_folders,
            Console& console) {
    const Promise promise = promise_for(scene_of(command), *command.max_error_world,
                                        read_front(data_folders), console.progress());
    command.overrides.push_back([promise](SceneFile& scene) { apply(promise, scene); });
    console.note(
        fmt::format("--max-error {}: filter {}{}, which promises {:.2g}", *command.max_error_world,
                    filter_name(promise.filter),
                    promise.resolution ? fmt::format(" at {} voxels", *promise.resolution) : "",
                    promise.error_world));
}

} // namespace

Verb render_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders,
                 std::vector<std::filesystem::path> data_folders) {
    const auto command = std::make_shared<RenderCommand>();
    CLI::App* app = add_render_options(program, *command);
    return {app, [command, shader_folders = std::move(shader_folders),
                  data_folders = std::move(data_folders)](Console& console) {
                if (command->max_error_world) choose(*command, data_folders, console);
                Rendering(*command, console).run(shader_folders);
            }};
}

} // namespace isocast
