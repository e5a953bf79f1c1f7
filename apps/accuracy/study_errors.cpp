// What a study compares: samples, hits, normals, curvatures, each with its truth.
// SPDX-License-Identifier: MPL-2.0
#include "apps/accuracy/study.h"

#include "filtering/curvature.h"
#include "filtering/reconstruct.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace isocast {

namespace {

/// Of values that are not known of every pixel: NaN where one is not. Nothing if none is.
std::optional<Error> error_of(const std::vector<double>& values) {
    Error error;
    double sum = 0;
    int count = 0;
    for (const double value : values) {
        if (std::isnan(value)) continue;
        sum += value * value;
        error.max = std::max(error.max, value);
        ++count;
    }
    if (count == 0) return std::nullopt;
    error.rms = std::sqrt(sum / count);
    return error;
}

void add(const std::string& name, const std::vector<double>& values,
         std::map<std::string, Error>& errors) {
    if (const auto error = error_of(values)) errors[name] = *error;
}

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

Vec3d vector_at(const Image& image, std::size_t pixel) {
    const float* p = image.rgba.data() + 4 * pixel;
    return {p[0], p[1], p[2]};
}

/// By the sine: acos of nearly one would round to 0.02 degrees.
double degrees_between(const Vec3d& a, const Vec3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

} // namespace

Error Study::sample_error(const FieldSource& field) const {
    constexpr int sample_count = 20000;
    std::mt19937_64 random(1);
    const std::vector<IndexBox> boxes = field.active_boxes();
    const auto reach = field.half_width_world();
    const bool has_signs = mesh_->verdict.is_closed() && mesh_->verdict.is_oriented();
    std::vector<double> errors;
    // 20: of the samples of active boxes more than one in 20 lies in the band.
    for (int i = 0; i < 20 * sample_count && std::ssize(errors) < sample_count; ++i) {
        const IndexBox& box = boxes[random() % boxes.size()];
        Index3 index;
        for (int axis = 0; axis < 3; ++axis)
            index[axis] =
                box.lo[axis] + static_cast<int>(random() % static_cast<unsigned>(box.size()[axis]));
        const double stored = sample(field, index);
        // Where the band ends samples hold its width, rounded.
        if (reach && std::abs(stored) >= static_cast<float>(*reach)) continue;
        ExactDistance::Hint hint = 0;
        const double exact =
            distance_->at(field.space().to_world(index.cast<double>()), hint).distance;
        errors.push_back(has_signs ? std::abs(stored - exact)
                                   : std::abs(std::abs(stored) - std::abs(exact)));
    }
    return error_of(errors).value_or(Error{});
}

const ReferenceCaster& Study::caster_of(const FieldObject& object, bool is_usual_field) {
    if (!caster_ || cast_field_ != object.field || cast_filter_ != object.filter) {
        caster_ = std::make_unique<ReferenceCaster>(
            *control_samples(object.field, object.filter, progress_), object.iso_world,
            ReferenceOptions{.kernel = kernel_of(object.filter)});
        cast_field_ = object.field;
        cast_filter_ = object.filter;
    }
    FirstHits& hits = reference_hits_[object.filter];
    if (is_usual_field && hits.empty()) {
        hits.resize(view_.pixel_count());
        for_each_pixel(
            view_,
            [&](std::size_t pixel) {
                hits[pixel] = caster_->hit(view_.ray(pixel))
                                  .value_or(std::numeric_limits<double>::infinity());
            },
            progress_);
    }
    return *caster_;
}

void Study::add_hit_errors(const Scene& scene, bool is_usual_field,
                           std::map<std::string, Error>& errors) {
    renderer_.draw(view_.camera, view_.width, view_.height,
                   {FrameImage::Hit, FrameImage::Gradient});
    const Image hits = renderer_.read(FrameImage::Hit);
    const Image gradients = renderer_.read(FrameImage::Gradient);
    const bool has_one_field = scene.objects.size() == 1 && !scene.objects[0].field->is_adaptive();
    const ReferenceCaster* caster =
        has_one_field && is_usual_field ? &caster_of(scene.objects[0], is_usual_field) : nullptr;
    // The same function's hits, if there is one; else the true surface's.
    const FirstHits* reference = caster   ? &reference_hits_.at(scene.objects[0].filter)
                                 : truth_ ? &truth_->hits
                                          : nullptr;
    const double near_world =
        subject_ == Subject::Molecule ? 1e-3 * diagonal_world_ : base_voxel_world_;

    const std::size_t count = view_.pixel_count();
    std::vector<double> surface(count, unknown), position(count, unknown), normal(count, unknown);
    Error search{.counts = {{"missed", 0}, {"false", 0}, {"behind", 0}, {"hits", 0}}};
    std::vector<char> is_behind(count);
    for_each_pixel(
        view_,
        [&](std::size_t pixel) {
            if (hits.rgba[4 * pixel + 3] == 0) return;
            const Vec3d from_eye = vector_at(hits, pixel);
            const Vec3d p_world = view_.camera.eye_world + from_eye;
            const Ray ray = view_.ray(pixel);
            const double along = (p_world - ray.origin_world).dot(ray.direction_world) /
                                 ray.direction_world.squaredNorm();
            if (reference && std::isfinite((*reference)[pixel]))
                is_behind[pixel] =
                    std::abs(along - (*reference)[pixel]) * ray.direction_world.norm() > near_world;
            // Of those alone that are where they should be: elsewhere f may be constant.
            if (caster && std::isfinite((*reference)[pixel]) && !is_behind[pixel]) {
                const Vec3d p_index = scene.objects[0].field->space().to_index(p_world);
                position[pixel] =
                    std::abs(caster->value(p_index)) / caster->gradient(p_index).norm();
            }
            if (!truth_) return;
            // What lies on another piece of the surface is counted, not measured.
            if (!std::isfinite(truth_->hits[pixel])) {
                if (subject_ == Subject::Molecule) return;
            } else if (subject_ == Subject::Molecule &&
                       std::abs(along - truth_->hits[pixel]) * ray.direction_world.norm() >
                           10 * near_world)
                return;
            surface[pixel] = truth_->distance_world(p_world, pixel);
            if (std::isfinite(truth_->hits[pixel]))
                normal[pixel] =
                    degrees_between(vector_at(gradients, pixel), truth_->normal(p_world, pixel));
        },
        progress_);
    if (truth_) {
        add("surface", surface, errors);
        add("normal", normal, errors);
    }
    if (caster) add("position", position, errors);
    if (!reference) return;
    if (!caster && subject_ != Subject::Molecule) return; // of another function
    for (std::size_t pixel = 0; pixel < count; ++pixel) {
        const bool is_hit = hits.rgba[4 * pixel + 3] != 0;
        const bool should_hit = std::isfinite((*reference)[pixel]);
        search.counts["hits"] += should_hit;
        search.counts["missed"] += should_hit && !is_hit;
        search.counts["false"] += is_hit && !should_hit;
        search.counts["behind"] += is_behind[pixel];
    }
    search.rms = search.max =
        double(search.counts["missed"] + search.counts["false"] + search.counts["behind"]) /
        std::max(1, search.counts["hits"]);
    errors["search"] = search;
}

void Study::add_curvature_error(const Scene& scene, std::map<std::string, Error>& errors) {
    if (!truth_ || !truth_->jet || scene.objects.size() != 1) return;
    const FieldObject& object = scene.objects.front();
    if (!is_smooth(kernel_of(object.derivative_filter.value_or(object.filter)))) return;
    renderer_.draw(view_.camera, view_.width, view_.height,
                   {FrameImage::Hit, FrameImage::Curvature});
    const Image hits = renderer_.read(FrameImage::Hit);
    const Image curvatures = renderer_.read(FrameImage::Curvature);
    std::vector<double> off(view_.pixel_count(), unknown);
    for_each_pixel(
        view_,
        [&](std::size_t pixel) {
            if (hits.rgba[4 * pixel + 3] == 0 || !std::isfinite(truth_->hits[pixel])) return;
            const Jet jet = truth_->jet(view_.camera.eye_world + vector_at(hits, pixel));
            const Curvatures exact = principal_curvatures(jet.gradient, jet.hessian);
            const float* k = curvatures.rgba.data() + 4 * pixel;
            off[pixel] =
                base_voxel_world_ * std::max(std::abs(k[0] - exact.k1), std::abs(k[1] - exact.k2));
        },
        progress_);
    add("curvature", off, errors);
}

} // namespace isocast
