// SPDX-License-Identifier: MPL-2.0
#include "apps/view/viewer.h"

#include "apps/picture.h"
#include "apps/picture_file.h"
#include "apps/view/navigation.h"
#include "filtering/reconstruct.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isocast::view {

namespace {

/// Keys of [quality] that need no other bricks.
bool is_of_search(const std::string& key) {
    return key == "quality.guarantee" || key == "quality.rate" || key == "quality.rate_factor" ||
           key == "quality.near" || key == "quality.refine_steps" || key == "quality.detail_pixels";
}

CameraSpec spec_of(const Camera& camera) {
    CameraSpec spec{
        .eye_world = camera.eye_world, .target_world = camera.target_world, .up = camera.up};
    if (camera.projection == Projection::Orthographic)
        spec.height_world = camera.height_world;
    else
        spec.fov_y_degrees = camera.fov_y_degrees;
    return spec;
}

} // namespace

std::string Probe::text() const {
    std::string out = fmt::format("position {:.6g} {:.6g} {:.6g}\nvalue {:.6g}\n|gradient| {:.6g}\n"
                                  "normal {:.4f} {:.4f} {:.4f}",
                                  p_world.x(), p_world.y(), p_world.z(), value_world, gradient,
                                  normal.x(), normal.y(), normal.z());
    if (curvature)
        out += fmt::format("\nk1 {:.6g}\nk2 {:.6g}\nk1 along {:.4f} {:.4f} {:.4f}", (*curvature)[0],
                           (*curvature)[1], direction_1.x(), direction_1.y(), direction_1.z());
    return out;
}

Viewer::Viewer(gl::Context& context, const std::filesystem::path& shader_folder, Options options,
               std::function<void()> wake)
    : context_(context), renderer_(context, shader_folder), canvas_(renderer_, shader_folder),
      options_(options), wake_(std::move(wake)) {}

void Viewer::say(std::string message) {
    messages_.push_back(std::move(message));
    // So many are read, if any.
    if (messages_.size() > 20) messages_.pop_front();
}

void Viewer::open(SceneFile scene) {
    try {
        check_scene(scene);
    } catch (const std::exception& error) {
        say(error.what());
        return;
    }
    if (loading_) {
        loading_->work.cancel();
        next_ = std::move(scene);
        return;
    }
    start(std::move(scene), {});
}

void Viewer::start(SceneFile scene, Loading::Prepare prepare) {
    asked_ = scene;
    loading_ = std::make_unique<Loading>(std::move(scene), std::move(prepare), objects_, wake_);
}

void Viewer::keep_error(double max_error_world) {
    if (loading_ || !is_loaded_) return;
    promised_ = std::make_shared<Promise>();
    start(scene_, [promised = promised_, max_error_world,
                   folders = options_.data_folders](SceneFile& scene, const Progress& progress) {
        *promised = promise_for(scene, max_error_world, read_front(folders), progress);
        apply(*promised, scene);
    });
}

void Viewer::compare() {
    if (!is_loaded_ || comparing_) return;
    // A sixteenth of the pixels: the reference takes a second for some ten thousand rays.
    comparing_ = std::make_unique<Comparing>(loaded_, camera(), std::max(1, canvas_.width() / 4),
                                             std::max(1, canvas_.height() / 4), wake_);
}

void Viewer::finish_comparing() {
    const std::unique_ptr<Comparing> done = std::move(comparing_);
    try {
        done->work.finish();
        canvas_.set_look(loaded_.look);
        renderer_.draw(done->camera, done->width, done->height, {FrameImage::Beauty});
        const Difference difference =
            difference_of(renderer_.read(FrameImage::Beauty), done->picture);
        canvas_.show_picture(difference.picture);
        say(fmt::format("from the reference at {} x {}: {:.2g} at most, rms {:.2g} (1 is white); "
                        "shown {:.0f} times",
                        done->width, done->height, difference.greatest, difference.rms,
                        difference.gain));
    } catch (const std::exception& error) {
        say(fmt::format("no reference: {}", error.what()));
    }
}

void Viewer::add_file(const std::filesystem::path& path) {
    try {
        if (path.extension() == ".toml") {
            open(read_scene_file(path));
            return;
        }
        SceneFile scene = next_ ? *next_ : loading_ ? asked_ : scene_;
        const Input input = input_from(path.string());
        SceneObject& object = scene.objects.emplace_back();
        source_of(object, input) = path.string();
        open(std::move(scene));
    } catch (const std::exception& error) {
        say(error.what());
    }
}

void Viewer::cancel_loading() {
    if (loading_) loading_->work.cancel();
}

void Viewer::set_camera(const Camera& camera) {
    canvas_.restart(camera);
    is_moving_ = true;
}

void Viewer::reset_camera() {
    if (!is_loaded_) return;
    const std::vector<Vec3d> points = renderer_.surface_points_world();
    set_camera(camera_from(scene_.camera, points, double(canvas_.width()) / canvas_.height()));
    // What was found of an object turns about its middle.
    Eigen::AlignedBox3d box;
    for (const Vec3d& p : points) box.extend(p);
    pivot_world_ = points.empty() ? camera().target_world : Vec3d(box.center());
}

void Viewer::frame() {
    if (!is_loaded_) return;
    const Camera& now = camera();
    CameraSpec spec{.direction_to_eye = (now.eye_world - now.target_world).normalized(),
                    .up = now.up};
    if (now.projection == Projection::Perspective) spec.fov_y_degrees = now.fov_y_degrees;
    const Camera framed = camera_from(spec, renderer_.surface_points_world(),
                                      double(canvas_.width()) / canvas_.height());
    set_camera(now.projection == framed.projection
                   ? framed
                   : with_other_projection(framed, framed.target_world));
}

void Viewer::resize(int width, int height) {
    if (width < 1 || height < 1 || (width == canvas_.width() && height == canvas_.height())) return;
    canvas_.resize(width, height);
    is_moving_ = true;
}

void Viewer::show_steps(std::optional<int> most_steps) {
    canvas_.show_steps(most_steps);
    is_moving_ = true;
}

void Viewer::set_samples(int samples) {
    options_.samples = samples;
    canvas_.restart(camera());
}

void Viewer::change(SceneFile scene, const std::string& key) {
    try {
        check_scene(scene);
        if (is_of_search(key)) {
            renderer_.set_quality(scene.quality);
            loaded_.quality = scene.quality;
            scene_ = std::move(scene);
            set_camera(camera());
        } else if (change_of_key(key) == Change::Look) {
            const Look look = look_of(scene, true);
            canvas_.set_look(look);
            loaded_.look = look;
            scene_ = std::move(scene);
        } else if (loading_) {
            say("a scene is loading: wait for it, or cancel it");
        } else if (change_of_key(key) == Change::Iso) {
            const Scene moved = objects_.compose(scene, {}, [](const std::string&) {});
            renderer_.set_isos(moved.objects);
            loaded_.objects = moved.objects;
            scene_ = std::move(scene);
            set_camera(camera());
        } else {
            open(std::move(scene));
        }
    } catch (const std::exception& error) {
        say(error.what());
    }
}

bool Viewer::is_busy() const {
    return (loading_ && loading_->work.is_done()) || (comparing_ && comparing_->work.is_done()) ||
           (is_loaded_ && (is_moving_ || !canvas_.is_complete(options_.samples)));
}

std::optional<Step> Viewer::step(const std::function<void(std::string_view, double)>& pump) {
    if (loading_ && loading_->work.is_done()) finish_loading(pump);
    if (comparing_ && comparing_->work.is_done()) finish_comparing();
    if (!is_loaded_ || canvas_.width() == 0) return std::nullopt;
    try {
        std::optional<Step> step;
        if (is_moving_) {
            is_moving_ = false;
            step = canvas_.draw_coarse(options_.target_milliseconds);
        } else {
            step = canvas_.refine(options_.target_milliseconds, options_.samples);
        }
        if (step) count(*step);
        return step;
    } catch (const std::exception& error) {
        say(error.what());
        is_loaded_ = false;
        return std::nullopt;
    }
}

void Viewer::count(const Step& step) {
    if (step.is_coarse || (step.round == 0 && counted_milliseconds_ == 0))
        counted_ = step.report;
    else
        for (std::size_t i = 0; i < counted_.passes.size(); ++i) {
            counted_.passes[i].milliseconds += step.report.passes[i].milliseconds;
            counted_.passes[i].ran |= step.report.passes[i].ran;
        }
    // Parts beside all surfaces have none.
    if (!step.report.notes.empty()) counted_.notes = step.report.notes;
    counted_milliseconds_ += step.milliseconds;
    if (step.is_coarse) {
        counted_milliseconds_ = 0;
        return;
    }
    if (!step.ends_round) return;
    report_ = counted_;
    picture_milliseconds_ = counted_milliseconds_;
    for (PassReport& pass : counted_.passes) pass = {.name = pass.name};
    counted_milliseconds_ = 0;
}

void Viewer::finish_loading(const std::function<void(std::string_view, double)>& pump) {
    const std::unique_ptr<Loading> done = std::move(loading_);
    try {
        if (done->work.is_cancelled() && !next_) throw Interrupted();
        if (!done->work.is_cancelled()) {
            done->work.finish();
            Scene scene = std::move(done->loaded);
            for (const std::string& warning : done->warnings) say(warning);
            scene.look = look_of(done->scene, true);
            const Scene before = loaded_;
            try {
                choose_fetch_for(done->scene, scene);
                load(std::move(scene), pump);
            } catch (...) {
                if (is_loaded_) load(before, {});
                throw;
            }
            const bool is_first = !is_loaded_;
            is_loaded_ = true;
            take_scene(done->scene);
            promise_ = promised_ ? std::optional(*promised_) : std::nullopt;
            ++load_count_;
            if (!renderer_.has_surface()) say(why_nothing_is_seen(loaded_));
            if (is_first) reset_camera();
            set_camera(camera());
        }
    } catch (const Interrupted&) {
        say("cancelled; what was there before is shown");
    } catch (const std::exception& error) {
        say(error.what());
    }
    promised_.reset();
    if (next_) {
        SceneFile next = std::move(*next_);
        next_.reset();
        open(std::move(next));
    }
}

void Viewer::choose_fetch_for(const SceneFile& file, Scene& scene) {
    if (!file.fetch && !scene.objects.empty() && (!fetch_ || fetch_for_ != hardest_filter(scene))) {
        fetch_for_ = hardest_filter(scene);
        fetch_ = choose_fetch(renderer_, context_.driver(), *fetch_for_, scene.storage);
    }
    if (file.fetch)
        scene.storage.fetch = *file.fetch;
    else if (fetch_)
        scene.storage.fetch = fetch_->fetch;
}

void Viewer::load(Scene scene, const Progress& progress) {
    LookNumbers numbers = renderer_.look_numbers();
    loaded_ = scene;
    renderer_.load(std::move(scene), progress);
    canvas_.set_look(loaded_.look);
    renderer_.set_look_numbers(std::move(numbers));
}

void Viewer::take_scene(SceneFile scene) {
    scene_ = std::move(scene);
    histogram_.reset();
    if (loaded_.objects.empty()) return;
    const FieldSubset subset = subset_of(*loaded_.objects.front().field, std::int64_t{1} << 18);
    if (!subset.values.empty()) histogram_ = histogram_of(subset.values);
}

SceneFile Viewer::scene_as_seen() const {
    SceneFile scene = scene_;
    scene.camera = spec_of(canvas_.camera());
    scene.output.width = canvas_.width();
    scene.output.height = canvas_.height();
    return scene;
}

void Viewer::save_scene(const std::filesystem::path& path) {
    try {
        write_scene_file(scene_as_seen(), path);
        say(fmt::format("saved {}", path.string()));
    } catch (const std::exception& error) {
        say(error.what());
    }
}

void Viewer::save_picture(const std::filesystem::path& path) {
    if (!is_loaded_) return;
    try {
        const SceneFile scene = scene_as_seen();
        renderer_.set_look(look_of(scene, is_opaque(scene, path)));
        // As `isocast render` finds them in this view; from here on the window shows these, too.
        renderer_.set_look_numbers({});
        PictureRequest request{.width = scene.output.width,
                               .height = scene.output.height,
                               .samples = scene.output.samples,
                               .pixel_filter = scene.output.pixel_filter};
        if (!is_png(path)) request.others = images_of(scene.output.layers.value_or(ExrLayers{}));
        const std::vector<PictureView> views = views_of(scene, canvas_.camera());
        PictureFile file(path, scene, views, {});
        draw_picture(source_of(renderer_), views, request,
                     [&](const std::vector<FrameImages>& rows) { file.write(rows); });
        file.finish();
        say(fmt::format("saved {}", path.string()));
    } catch (const std::exception& error) {
        say(error.what());
    }
    canvas_.set_look(loaded_.look);
    canvas_.restart(camera());
}

std::optional<Probe> Viewer::probe(double x, double y) {
    if (!is_loaded_ || x < 0 || y < 0 || x >= canvas_.width() || y >= canvas_.height())
        return std::nullopt;
    const PicturePart pixel{
        .x = static_cast<int>(x), .y = static_cast<int>(y), .width = 1, .height = 1};
    const bool has_fields = !loaded_.objects.empty();
    ImageSet wanted{FrameImage::Hit, FrameImage::Gradient};
    if (has_fields) wanted.insert({FrameImage::Curvature, FrameImage::Direction});
    renderer_.draw(camera(), canvas_.width(), canvas_.height(), wanted, pixel);
    const auto read = [&](FrameImage image) {
        const Image out = renderer_.read(image);
        return Eigen::Vector4d(out.rgba[0], out.rgba[1], out.rgba[2], out.rgba[3]);
    };
    const Eigen::Vector4d hit = read(FrameImage::Hit);
    if (hit.w() == 0) return std::nullopt;
    Probe probe{.p_world = camera().eye_world + hit.head<3>()};
    const Vec3d gradient = read(FrameImage::Gradient).head<3>();
    probe.gradient = gradient.norm();
    probe.normal = gradient.stableNormalized();
    // Of primitives there is neither a value nor a curvature.
    const auto object = static_cast<std::size_t>(std::abs(hit.w())) - 1;
    if (object >= loaded_.objects.size()) return probe;
    probe.value_world = loaded_.objects[object].iso_world;
    const std::vector<ScenePart> parts = composition_of(scene_).parts;
    if (parts.size() == loaded_.objects.size() && parts[object].plane) {
        const FieldSource& field = *loaded_.objects.front().field;
        probe.value_world =
            kernel_value(field, field.space().to_index(probe.p_world), Kernel::CatmullRom);
    }
    const Eigen::Vector4d curvature = read(FrameImage::Curvature);
    probe.curvature = {curvature.x(), curvature.y()};
    probe.direction_1 = read(FrameImage::Direction).head<3>();
    return probe;
}

} // namespace isocast::view
