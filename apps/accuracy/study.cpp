// SPDX-License-Identifier: MPL-2.0
#include "apps/accuracy/study.h"

#include "apps/gpu_scanner.h"
#include "apps/picture.h"
#include "distance_transform/convert_adaptive.h"
#include "raycaster/fetch_choice.h"
#include "volume/errors.h"
#include "volume/octree_file.h"
#include "volume/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// Meshes, unless a setting says another: coarse enough for a reference at every pixel.
constexpr int usual_resolution = 128;

/// Without a setting's value: of methods that `isocast render` has no key for.
std::string value_of(const Setting& setting, const char* knob, const char* usual) {
    const auto found = setting.find(knob);
    return found == setting.end() ? usual : found->second;
}

BandMethod band_method_from(const std::string& name) {
    if (name == "prism") return BandMethod::Scan;
    if (name == "printed") return BandMethod::PrintedPrisms;
    if (name == "csc") return BandMethod::Csc;
    throw UsageError(fmt::format("method: '{}' is none of prism, printed, csc, kdtree", name));
}

SceneFile base_scene(const StudyOptions& options, Subject subject) {
    RenderCommand command;
    command.inputs = {options.input};
    // Spheres alone: what the field of a molecule's surface shows too.
    if (subject == Subject::Molecule) command.settings = {"object.0.style=space-filling"};
    if (subject == Subject::Mesh)
        command.settings = {fmt::format("object.0.resolution={}", usual_resolution)};
    command.settings.insert(command.settings.end(), options.settings.begin(),
                            options.settings.end());
    SceneFile scene = scene_of(command);
    scene.output.width = options.width;
    scene.output.height = options.height;
    return scene;
}

void no_warning(const std::string&) {}

} // namespace

/// A field, or what it is composed from, and what it took.
struct Study::Made {
    std::unique_ptr<SceneObjects> objects = std::make_unique<SceneObjects>();
    std::shared_ptr<const FieldSource> field; // of a conversion that scenes have no keys for
    std::string octree;                       // its file
    double seconds = 0;
};

Study::~Study() = default;

Study::Study(StudyOptions options, gl::Context& context, Renderer& renderer, Progress progress)
    : options_(std::move(options)), context_(context), renderer_(renderer),
      progress_(std::move(progress)), input_(input_from(options_.input)),
      subject_(subject_of(input_)), base_(base_scene(options_, subject_)) {
    if (subject_ == Subject::Mesh) {
        mesh_ = read_checked_mesh(input_);
        distance_.emplace(mesh_->mesh, mesh_->topology, nullptr);
    }
    if (subject_ != Subject::Molecule)
        fetch_ =
            choose_fetch(renderer_, context_.driver(), Filter::CatmullRom, base_.storage).fetch;

    RoundSeconds seconds;
    const Scene scene = load({}, base_, seconds);
    if (!renderer_.has_surface())
        throw InputError(fmt::format("{}: there is no surface to measure", options_.input));
    const std::vector<Vec3d> points = renderer_.surface_points_world();
    view_ = {camera_from(base_.camera, points, double(options_.width) / options_.height),
             options_.width, options_.height};
    Eigen::AlignedBox3d box;
    for (const Vec3d& point : points) box.extend(point);
    diagonal_world_ = box.diagonal().norm();
    if (!scene.objects.empty()) {
        base_voxel_world_ = scene.objects.front().field->space().voxel_size_world();
        brick_mib_ = double(renderer_.pool().brick_count()) *
                     double(BrickLayout(scene.storage).brick_bytes) / (1 << 20);
    }
    switch (subject_) {
    case Subject::Mesh:
        truth_ = truth_of(*mesh_, *distance_, view_, progress_);
        break;
    case Subject::BuiltinField: {
        const AnalyticField field =
            at_iso(builtin_field(input_.name), scene.objects.front().iso_world);
        truth_ = truth_of(field, base_voxel_world_, view_, progress_);
        break;
    }
    case Subject::Molecule:
        truth_ = truth_of(*scene.primitives, view_);
        break;
    case Subject::FieldFile:
        break;
    }
}

SceneFile Study::scene_at(const Setting& setting) const {
    SceneFile scene = base_;
    apply(setting, subject_, scene);
    check_scene(scene);
    return scene;
}

void Study::new_round() {
    made_.clear();
}

Study::Made Study::made_by_converting(const Setting& of_field, const SceneFile& scene) {
    const SceneObject& object = scene.objects.front();
    const WorldBox box = bounding_box(mesh_->mesh);
    Made made;
    if (of_field.contains("octree_error")) {
        if (of_field.size() > 1)
            throw UsageError("octree_error: an octree has no other knobs of its field");
        const double error = number_from(of_field.at("octree_error")) * box.size().maxCoeff();
        const AdaptiveConvertResult result =
            convert_adaptive(*mesh_, {.max_error_world = error}, progress_);
        made.octree = (options_.folder / "octree.hoct").string();
        write_octree(result.tree, result.space, {}, made.octree);
        return made;
    }
    ConvertOptions convert_options{
        .voxel_size_world = voxel_size_for_resolution(box, object.resolution.value_or(256)),
        .half_width_voxels = object.band_voxels};
    const std::string method = value_of(of_field, "method", "prism");
    const std::string device = value_of(of_field, "device", "cpu");
    if (device != "cpu" && device != "gl")
        throw UsageError(fmt::format("device: '{}' is none of cpu, gl", device));
    if (method == "kdtree") {
        made.field =
            std::make_shared<DenseField>(convert_dense(*mesh_, convert_options, progress_).field);
        return made;
    }
    convert_options.method = band_method_from(method);
    if (device == "gl") convert_options.scanner = gpu_scanner(options_.shader_folders);
    made.field = std::make_shared<SparseField>(convert(*mesh_, convert_options, progress_).field);
    if (device == "gl") context_.make_current();
    return made;
}

Study::Made& Study::made_at(const Setting& setting, const SceneFile& scene) {
    const Setting of_field = field_part(setting, subject_);
    std::unique_ptr<Made>& kept = made_[text_of(of_field)];
    if (kept) return *kept;
    const Stopwatch time;
    auto made = std::make_unique<Made>();
    if (of_field.contains("method") || of_field.contains("device") ||
        of_field.contains("octree_error"))
        *made = made_by_converting(of_field, scene);
    SceneFile read = scene;
    if (!made->octree.empty()) {
        read.objects.front().mesh.clear();
        read.objects.front().field = made->octree;
    }
    if (!made->field) {
        made->objects->open(read);
        made->objects->compose(read, progress_, no_warning); // converts, and keeps the field
        if (!made->octree.empty()) std::filesystem::remove(made->octree);
    }
    made->seconds = time.seconds();
    kept = std::move(made);
    return *kept;
}

Scene Study::load(const Setting& setting, const SceneFile& scene, RoundSeconds& seconds) {
    // What the last setting had alike would be kept, and not be timed.
    static const auto something_else =
        std::shared_ptr<const FieldSource>(sampled(builtin_field("sphere"), 8));
    renderer_.load({.field = something_else});
    Made& made = made_at(setting, scene);
    seconds["field"] = made.seconds;
    Scene loaded;
    if (made.field) {
        loaded = {.storage = scene.storage, .quality = scene.quality};
        loaded.objects = {{made.field, 0, scene.filter, scene.derivative_filter}};
    } else {
        SceneFile read = scene;
        if (!made.octree.empty()) {
            read.objects.front().mesh.clear();
            read.objects.front().field = made.octree;
        }
        loaded = made.objects->compose(read, progress_, no_warning);
    }
    loaded.look = look_of(scene, true);
    loaded.storage.fetch = scene.fetch.value_or(fetch_);
    const Stopwatch time;
    renderer_.load(loaded, progress_);
    seconds["load"] = time.seconds();
    return loaded;
}

Image Study::draw_beauty(const SceneFile& scene) {
    const PictureRequest request{.width = view_.width,
                                 .height = view_.height,
                                 .samples = scene.output.samples,
                                 .pixel_filter = scene.output.pixel_filter};
    Image picture{view_.width, view_.height, {}};
    draw_picture(source_of(renderer_), {{.camera = view_.camera, .picture_width = view_.width}},
                 request, [&](const std::vector<FrameImages>& rows) {
                     const auto& more = rows.front().at(FrameImage::Beauty).rgba;
                     picture.rgba.insert(picture.rgba.end(), more.begin(), more.end());
                 });
    return picture;
}

RoundSeconds Study::seconds_at(const Setting& setting) {
    const SceneFile scene = scene_at(setting);
    RoundSeconds seconds;
    load(setting, scene, seconds);
    const Stopwatch time;
    draw_beauty(scene);
    seconds["frame"] = time.seconds();
    return seconds;
}

std::map<std::string, Error> Study::errors_at(const Setting& setting) {
    std::map<std::string, Error> errors;
    if (const std::optional<Setting> best = best_picture_of(setting, subject_)) {
        Image& truth = best_pictures_[text_of(*best)];
        RoundSeconds unused;
        if (truth.rgba.empty()) {
            const SceneFile scene = scene_at(*best);
            load(*best, scene, unused);
            truth = draw_beauty(scene);
        }
    }
    const SceneFile scene = scene_at(setting);
    RoundSeconds unused;
    const Scene loaded = load(setting, scene, unused);
    const bool is_usual_field = field_part(setting, subject_).empty();
    if (loaded.objects.size() == 1 && subject_ == Subject::Mesh &&
        !setting.contains("octree_error"))
        errors["samples"] = sample_error(*loaded.objects.front().field);
    picture_ = draw_beauty(scene);
    if (const std::optional<Setting> best = best_picture_of(setting, subject_)) {
        const Image& truth = best_pictures_.at(text_of(*best));
        Error& error = errors["picture"];
        double sum = 0;
        for (std::size_t i = 0; i < truth.rgba.size(); ++i) {
            if (i % 4 == 3) continue; // coverage
            const double off = std::abs(double(truth.rgba[i]) - double(picture_.rgba[i]));
            sum += off * off;
            error.max = std::max(error.max, off);
        }
        error.rms = std::sqrt(sum / (0.75 * double(truth.rgba.size())));
        return errors; // hits do not depend on it
    }
    add_hit_errors(loaded, is_usual_field, errors);
    add_curvature_error(loaded, errors);
    return errors;
}

} // namespace isocast
