// SPDX-License-Identifier: MPL-2.0
#include "raycaster/reference_renderer.h"

#include "filtering/blocks.h"
#include "filtering/curvature.h"
#include "filtering/reconstruct.h"
#include "filtering/smoothed_field.h"
#include "raycaster/splats_on_gpu.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

namespace isocast {

namespace {

/// Roots of two objects that are nearer to each other are at one place: a thousandth of what
/// float32 resolves [voxel].
constexpr double tie_voxels = 1e-9;

bool has_primitives(const Scene& scene) {
    return scene.primitives && scene.primitives->count() > 0;
}

bool is_known(FrameImage image) {
    return image == FrameImage::Hit || image == FrameImage::Gradient ||
           image == FrameImage::Curvature || image == FrameImage::Direction ||
           image == FrameImage::Beauty;
}

void put(Image& image, std::size_t pixel, const Vec3d& v, double w) {
    for (int c = 0; c < 3; ++c)
        image.rgba[4 * pixel + static_cast<std::size_t>(c)] = static_cast<float>(v[c]);
    image.rgba[4 * pixel + 3] = static_cast<float>(w);
}

} // namespace

void ReferenceRenderer::load(Scene scene, const Progress& progress) {
    const std::vector<FieldObject> objects = objects_of(scene);
    std::vector<std::string> lacking = not_in_reference(scene.look);
    if (std::ranges::any_of(objects, [](const FieldObject& o) { return o.field->is_adaptive(); }))
        lacking.emplace_back("octrees");
    if (has_primitives(scene) && uses_curvature(scene.look))
        lacking.emplace_back("curvatures of primitives");
    if (!lacking.empty())
        throw InputError(fmt::format("the reference does not draw: {}", fmt::join(lacking, ", ")));
    if (scene.primitives) check(*scene.primitives);
    check(scene.cut);

    objects_.clear();
    images_.clear();
    scene_ = std::move(scene);
    boxes_.clear();
    primitives_box_ = {};
    if (has_primitives(scene_)) primitives_box_ = box_of(*scene_.primitives);
    for (const FieldObject& object : objects) {
        const Filter derivative_filter = object.derivative_filter.value_or(object.filter);
        const auto control = control_samples(object.field, object.filter, progress);
        const auto derivative_control =
            share_control_samples(object.filter, derivative_filter)
                ? control
                : control_samples(object.field, derivative_filter, progress);
        const auto curvature_control =
            scene_.curvature_scale_voxels > 0
                ? control_samples(
                      std::make_shared<SmoothedField>(object.field, scene_.curvature_scale_voxels),
                      derivative_filter, progress)
                : derivative_control;
        const Kernel kernel = kernel_of(object.filter);
        objects_.push_back(
            {object, {}, derivative_control, curvature_control, kernel_of(derivative_filter)});
        objects_.back().caster.emplace(control, kernel, object.iso_world, progress);
        const float iso = static_cast<float>(object.iso_world);
        const BlockRanges ranges = find_block_ranges(*control, kernel, progress);
        boxes_.push_back(find_surface_box(*control, ranges, active_pages(ranges, iso), iso));
    }
    if (!objects_.empty())
        inside_ = inside_table(tree_of(scene_), static_cast<int>(objects_.size()));
}

/// As shaders/raycast/compose.frag: the objects' roots in order, until the ray enters the solid or
/// leaves it.
ReferenceRenderer::Hit ReferenceRenderer::first_hit(const Ray& ray) const {
    struct Next {
        CertifiedCaster::Walk walk;
        std::optional<double> t;
        double tie; // t of tie_voxels
    };
    std::vector<Next> next;
    unsigned set = 0; // of the objects that the ray is in
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        CertifiedCaster::Walk walk = objects_[i].caster->walk(ray);
        if (walk.starts_inside()) set |= 1U << i;
        const GridSpace& space = objects_[i].of.field->space();
        const double voxels =
            (space.world_from_index.linear().inverse() * ray.direction_world).norm();
        const auto t = walk.next();
        next.push_back({std::move(walk), t, tie_voxels / voxels});
    }
    const bool was_inside = inside_.is_inside(set);
    for (;;) {
        double first_end = std::numeric_limits<double>::infinity();
        for (const Next& n : next)
            if (n.t) first_end = std::min(first_end, *n.t + n.tie);
        if (!std::isfinite(first_end)) return {};
        // All roots at that place; at some the ray may enter a solid that it leaves at others.
        bool is_inside = was_inside;
        Hit hit;
        for (;;) {
            std::size_t nearest = next.size();
            for (std::size_t i = 0; i < next.size(); ++i)
                if (next[i].t && *next[i].t - next[i].tie <= first_end &&
                    (nearest == next.size() || *next[i].t < *next[nearest].t))
                    nearest = i;
            if (nearest == next.size()) break;
            const bool was_in_object = (set >> nearest & 1) != 0;
            set ^= 1U << nearest;
            if (const bool is_now = inside_.is_inside(set); is_now != is_inside) {
                const int number = static_cast<int>(nearest) + 1;
                hit = {was_in_object != is_inside ? -number : number, *next[nearest].t};
                is_inside = is_now;
            }
            next[nearest].t = next[nearest].walk.next();
        }
        if (is_inside != was_inside) return hit;
    }
}

ReferenceSurface ReferenceRenderer::surface_at(const Hit& hit, const Ray& ray, bool with_curvature,
                                               float& flag) const {
    const Object& object = objects_[static_cast<std::size_t>(std::abs(hit.object)) - 1];
    const GridSpace& space = object.of.field->space();
    const Vec3d p_index = space.to_index(ray.origin_world + hit.t * ray.direction_world);
    // The composed function is the negative of an object that is taken away.
    const double sign = hit.object < 0 ? -1 : 1;
    ReferenceSurface surface;
    const Jet jet = kernel_jet(*object.derivative_control, p_index, object.derivative_kernel);
    surface.gradient = sign * space.gradient_to_world(jet.gradient);
    const Vec3d colour = object.of.colour.value_or(scene_.look.material.colour);
    surface.colour = hit.object < 0 ? object.of.cut_colour.value_or(colour) : colour;
    if (!with_curvature) return surface;
    const Jet bend = object.curvature_control == object.derivative_control
                         ? jet
                         : kernel_jet(*object.curvature_control, p_index, object.derivative_kernel);
    const Vec3d gradient = sign * space.gradient_to_world(bend.gradient);
    const Mat3d hessian = sign * space.hessian_to_world(bend.hessian);
    surface.curvature = principal_curvatures(gradient, hessian);
    surface.view_curvature = normal_curvature(gradient, hessian, ray.direction_world);
    // 2^-44: the Hessian's sums of 64 products, and a few roundings more.
    const double difference = surface.curvature.k1 - surface.curvature.k2;
    flag = gradient.norm() == 0                                       ? 2
           : difference * gradient.norm() <= 0x1p-44 * hessian.norm() ? 3
                                                                      : 1;
    return surface;
}

FrameReport ReferenceRenderer::draw(const Camera& camera, int width, int height,
                                    const ImageSet& wanted, const PicturePart& part,
                                    const Progress& progress) {
    const auto begin = std::chrono::steady_clock::now();
    images_.clear();
    const auto pixels =
        static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height);
    for (int i = 0; i < frame_image_count; ++i) {
        const auto image = static_cast<FrameImage>(i);
        if (!wanted.contains(image)) continue;
        const bool is_of_curvature =
            image == FrameImage::Curvature || image == FrameImage::Direction;
        if (!is_known(image) || (is_of_curvature && has_primitives(scene_)))
            throw InputError(fmt::format("the reference does not draw the image '{}'{}",
                                         name_of(image), is_known(image) ? " of primitives" : ""));
        images_[image] = {part.width, part.height, std::vector<float>(4 * pixels)};
    }
    const bool has_beauty = wanted.contains(FrameImage::Beauty);
    const bool with_curvature = wanted.contains(FrameImage::Curvature) ||
                                wanted.contains(FrameImage::Direction) ||
                                (has_beauty && uses_curvature(scene_.look));
    std::vector<SeenPrimitive> primitives;
    if (has_primitives(scene_))
        primitives = cast_primitives(*scene_.primitives, camera, width, height, scene_.cut, part);
    const int number_of_primitives = static_cast<int>(objects_.size()) + 1;
    const ReferenceShading shading(scene_.look, camera, height);
    const auto set = [&](FrameImage image, std::size_t pixel, const Vec3d& v, double w) {
        if (const auto found = images_.find(image); found != images_.end())
            put(found->second, pixel, v, w);
    };
    std::atomic<int> rows_done = 0;
    tbb::parallel_for(0, part.height, [&](int y) {
        for (int x = 0; x < part.width; ++x) {
            const std::size_t pixel =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(part.width) +
                static_cast<std::size_t>(x);
            const Ray ray = camera_ray(camera, width, height, part.x + x + 0.5 + part.shift.x(),
                                       part.y + y + 0.5 + part.shift.y());
            Hit hit = first_hit(ray);
            ReferenceSurface surface;
            float flag = 0;
            if (!primitives.empty() && primitives[pixel].number >= 0 &&
                (hit.object == 0 || primitives[pixel].t < hit.t)) {
                hit = {number_of_primitives, primitives[pixel].t};
                surface.gradient = primitives[pixel].shaded_normal;
                surface.colour = primitives[pixel].colour;
            } else if (hit.object != 0) {
                surface = surface_at(hit, ray, with_curvature, flag);
            }
            surface.from_eye = ray.origin_world - camera.eye_world + hit.t * ray.direction_world;
            if (has_beauty) {
                const Eigen::Vector4d colour =
                    shading.colour(hit.object == 0 ? nullptr : &surface, ray.direction_world);
                set(FrameImage::Beauty, pixel, colour.head<3>(), colour.w());
            }
            if (hit.object == 0) continue;
            const Curvatures& k = surface.curvature;
            set(FrameImage::Hit, pixel, surface.from_eye, hit.object);
            set(FrameImage::Gradient, pixel, surface.gradient, 1);
            set(FrameImage::Curvature, pixel, {k.k1, k.k2, 0}, flag);
            set(FrameImage::Direction, pixel, k.direction1,
                flag == 1 ? (k.k1 - k.k2) / (std::abs(k.k1) + std::abs(k.k2)) : 0);
        }
        if (progress) progress("casting rays", double(++rows_done) / part.height);
    });
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
    FrameReport report;
    report.passes.push_back(
        {.name = "reference", .ran = true, .asked_by = "output", .milliseconds = time.count()});
    return report;
}

} // namespace isocast
