// SPDX-License-Identifier: MPL-2.0
#include "apps/accuracy/promise.h"

#include "apps/accuracy/settings.h"
#include "distance_transform/convert.h"
#include "filtering/reconstruct.h"
#include "volume/errors.h"
#include "volume/histogram.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace isocast {

namespace {

constexpr int greatest_resolution = 1024;

/// Steps of a factor of sqrt(2) from 16 on.
int resolution_of_step(int step) {
    return static_cast<int>(std::lround(16 * std::exp2(0.5 * step)));
}

struct Probed {
    double error_world;
    double voxel_world;
};

/// probed(filter, resolution) is called as seldom as can be, from coarse to fine.
template<class ProbedAt>
Promise cheapest(std::span<const FrontPoint> front, std::span<const Filter> filters,
                 double max_error_world, const ProbedAt& probed_at) {
    if (!(max_error_world > 0))
        throw UsageError(fmt::format("--max-error {}: a length above 0", max_error_world));
    std::optional<Promise> best;
    double least = std::numeric_limits<double>::infinity();
    for (int step = 0; resolution_of_step(step) <= greatest_resolution; ++step) {
        const int resolution = resolution_of_step(step);
        for (const Filter filter : filters) {
            const double seconds = seconds_of(front, filter, resolution);
            if (best && best->seconds <= seconds) continue;
            const Probed probed = probed_at(filter, resolution);
            const double error = ratio_of(front, filter) * probed.error_world +
                                 hit_error_voxels(resolution) * probed.voxel_world;
            least = std::min(least, error);
            if (error <= max_error_world) best = {filter, resolution, error, seconds};
        }
        // Finer ones cost more.
        if (best) return *best;
    }
    throw InputError(
        fmt::format("--max-error {}: {} voxels would err by {:.2g}; the front promises "
                    "nothing beyond",
                    max_error_world, greatest_resolution, least));
}

/// Onto the zero set of f, along its gradient; nothing if that does not lead there.
std::optional<Vec3d> on_surface(const std::function<Jet(const Vec3d&)>& f, Vec3d p,
                                double tolerance) {
    // 20: Newton's method doubles its digits with each; it fails where the gradient vanishes.
    for (int i = 0; i < 20; ++i) {
        const Jet jet = f(p);
        const double slope = jet.gradient.squaredNorm();
        if (!(slope > 0)) return std::nullopt;
        const Vec3d step = jet.value / slope * jet.gradient;
        p -= step;
        if (step.norm() < tolerance) return p;
    }
    return std::nullopt;
}

} // namespace

double ratio_of(std::span<const FrontPoint> points, Filter filter) {
    double ratio = 1;
    for (const FrontPoint& point : points)
        if (point.filter == filter) ratio = std::max(ratio, point.ratio);
    return 1.25 * ratio;
}

double seconds_of(std::span<const FrontPoint> points, Filter filter, int resolution) {
    std::vector<std::pair<double, double>> logs;
    for (const FrontPoint& point : points)
        if (point.filter == filter)
            logs.emplace_back(std::log(point.resolution), std::log(point.seconds));
    std::ranges::sort(logs);
    if (logs.size() < 2)
        throw InputError(
            fmt::format("the front knows {} at fewer than two resolutions", filter_name(filter)));
    const double x = std::log(resolution);
    std::size_t i = 1;
    while (i + 1 < logs.size() && logs[i].first < x) ++i;
    const auto [x0, y0] = logs[i - 1];
    const auto [x1, y1] = logs[i];
    return std::exp(y0 + (y1 - y0) * (x - x0) / (x1 - x0));
}

std::vector<Vec3d> surface_points(const AnalyticField& field, int count) {
    std::mt19937_64 random(2);
    const double half = field.half_extent_world;
    std::uniform_real_distribution<double> place(-half, half);
    std::vector<Vec3d> points;
    // 100: of surfaces that fill a hundredth of their cube.
    for (int i = 0; i < 100 * count && std::ssize(points) < count; ++i) {
        const Vec3d start(place(random), place(random), place(random));
        const auto p = on_surface(field.jet, start, 1e-12 * half);
        if (p && p->cwiseAbs().maxCoeff() <= half) points.push_back(*p);
    }
    if (points.empty())
        throw InputError(fmt::format("{}: no point of its surface was found", field.name));
    return points;
}

std::vector<Vec3d> surface_points(const Mesh& mesh, int count) {
    std::mt19937_64 random(2);
    std::vector<double> area_before{0};
    const auto corner = [&](std::size_t triangle, std::size_t k) -> const Vec3d& {
        return mesh.vertices_world[static_cast<std::size_t>(mesh.triangles[triangle][k])];
    };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        area_before.push_back(
            area_before.back() +
            (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm() / 2);
    std::uniform_real_distribution<double> any(0, 1);
    std::vector<Vec3d> points;
    for (int i = 0; i < count; ++i) {
        const auto found = std::ranges::upper_bound(area_before, any(random) * area_before.back());
        const auto t = std::min(static_cast<std::size_t>(found - area_before.begin()) - 1,
                                mesh.triangles.size() - 1);
        // Even over the triangle: the half of the square where u + v > 1 is turned over.
        double u = any(random);
        double v = any(random);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        if (i % 4 == 2) v = 0;     // on an edge
        if (i % 4 == 3) u = v = 0; // in a corner
        points.push_back(corner(t, 0) + u * (corner(t, 1) - corner(t, 0)) +
                         v * (corner(t, 2) - corner(t, 0)));
    }
    return points;
}

double probe(const FieldSource& field, double iso_world, Filter filter,
             std::span<const Vec3d> points_world) {
    // The control samples of the others are views; Exact is not among the front's filters.
    const auto control = control_samples(
        std::shared_ptr<const FieldSource>(std::shared_ptr<void>(), &field), filter);
    const IndexBox extent = field.extent();
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, points_world.size()), 0.0,
        [&](const tbb::blocked_range<std::size_t>& range, double greatest) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                const Vec3d p_index = field.space().to_index(points_world[i]);
                if ((p_index.array() < extent.lo.cast<double>().array()).any() ||
                    (p_index.array() > extent.hi.cast<double>().array() - 1).any())
                    continue;
                const Jet jet = kernel_jet(*control, p_index, kernel_of(filter));
                greatest =
                    std::max(greatest, std::abs(jet.value - iso_world) /
                                           field.space().gradient_to_world(jet.gradient).norm());
            }
            return greatest;
        },
        [](double a, double b) { return std::max(a, b); });
}

Promise promise_for(const AnalyticField& field, double max_error_world, const Front& front) {
    const std::vector<Vec3d> points = surface_points(field, probe_point_count);
    const auto probed_at = [&](Filter filter, int resolution) {
        const auto samples = sampled(field, resolution);
        return Probed{probe(*samples, 0, filter, points), samples->space().voxel_size_world()};
    };
    return cheapest(front.fields, front_filters, max_error_world, probed_at);
}

Promise promise_for(const CheckedMesh& mesh, double max_error_world, const Front& front,
                    const Progress& progress, std::span<const Filter> filters) {
    const std::vector<Vec3d> points = surface_points(mesh.mesh, probe_point_count);
    const WorldBox box = bounding_box(mesh.mesh);
    std::optional<SparseField> field;
    int resolution_of_field = 0;
    const auto probed_at = [&](Filter filter, int resolution) {
        if (resolution != resolution_of_field)
            field = convert(mesh, {.voxel_size_world = voxel_size_for_resolution(box, resolution)},
                            progress)
                        .field;
        resolution_of_field = resolution;
        return Probed{probe(*field, 0, filter, points), field->space().voxel_size_world()};
    };
    return cheapest(front.meshes, filters, max_error_world, probed_at);
}

Promise promise_for(const std::shared_ptr<const FieldSource>& field, double iso_world,
                    double max_error_world, const Front& front) {
    const auto control = control_samples(field, Filter::Interpolating);
    const GridSpace& space = field->space();
    const auto jet_at = [&](const Vec3d& p_index) {
        Jet jet = tricubic_jet(*control, p_index);
        jet.value -= iso_world;
        return jet;
    };
    std::mt19937_64 random(2);
    const std::vector<IndexBox> boxes = field->active_boxes();
    std::vector<Vec3d> points;
    for (int i = 0; i < 100 * probe_point_count && std::ssize(points) < probe_point_count; ++i) {
        const IndexBox& box = boxes[random() % boxes.size()];
        Vec3d start;
        for (int axis = 0; axis < 3; ++axis)
            start[axis] = std::uniform_real_distribution<double>(
                box.lo[axis], std::max(box.lo[axis] + 1, box.hi[axis] - 1))(random);
        // Only from nearby: farther samples may be those of a band's end.
        const Jet jet = jet_at(start);
        if (!(std::abs(jet.value) < jet.gradient.norm())) continue;
        if (const auto p = on_surface(jet_at, start, 1e-9); p && (*p - start).norm() < 2)
            points.push_back(space.to_world(*p));
    }
    if (points.empty()) throw InputError("--max-error: no point of the surface was found");
    const double of_interpolating = probe(*field, iso_world, Filter::CatmullRom, points);
    const int resolution = field->extent().size().maxCoeff();
    std::optional<Promise> best;
    double least = of_interpolating;
    for (const Filter filter : front_filters) {
        const double seconds = seconds_of(front.fields, filter, resolution);
        const double error =
            of_interpolating + hit_error_voxels(resolution) * space.voxel_size_world() +
            (filter == Filter::Interpolating ? 0 : probe(*field, iso_world, filter, points));
        least = std::min(least, error);
        if (error <= max_error_world && (!best || seconds < best->seconds))
            best = {filter, std::nullopt, error, seconds};
    }
    if (!best)
        throw InputError(fmt::format("--max-error {}: the field's samples promise no better than "
                                     "{:.2g}",
                                     max_error_world, least));
    return *best;
}

Promise promise_for(const SceneFile& scene, double max_error_world, const Front& front,
                    const Progress& progress) {
    const auto refuse = [] {
        throw UsageError("--max-error: for one mesh or one field; --set object.0.resolution and "
                         "--filter serve the rest");
    };
    if (scene.objects.size() != 1) refuse();
    const SceneObject& object = scene.objects.front();
    if (!has_field(object) || (object.mesh.empty() && object.field.empty())) refuse();
    // Promised of the object as its file has it.
    const double max_error = max_error_world / object.placement.scale;
    const double iso = object.iso_world.value_or(0);
    if (!object.mesh.empty()) {
        if (iso != 0) throw UsageError("--max-error: of a mesh's own surface, at iso 0");
        return promise_for(read_checked_mesh(input_from(object.mesh)), max_error, front, progress);
    }
    const Input input = input_from(object.field);
    if (input.kind == Input::Kind::BuiltinField)
        return promise_for(at_iso(builtin_field(input.name), iso), max_error, front);
    const std::shared_ptr<const FieldSource> field = read_field(input);
    if (field->is_adaptive())
        throw UsageError("--max-error: an octree keeps the error it was converted with");
    return promise_for(field, object.iso_world ? iso : suggested_iso(*field).iso, max_error, front);
}

void apply(const Promise& promise, SceneFile& scene) {
    SceneObject& object = scene.objects.front();
    scene.filter = promise.filter;
    object.filter.reset();
    if (promise.resolution) set_resolution(object, *promise.resolution);
}

} // namespace isocast
