// SPDX-License-Identifier: MPL-2.0
#include "apps/accuracy/truth.h"

#include "raycaster/primitives_reference.h"
#include "raycaster/ray_span.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>

namespace isocast {

namespace {

constexpr double nowhere = std::numeric_limits<double>::infinity();

double greatest_slope(const AnalyticField& field) {
    std::mt19937_64 random(1);
    const double half = field.half_extent_world;
    std::uniform_real_distribution<double> place(-half, half);
    double greatest = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec3d p(place(random), place(random), place(random));
        greatest = std::max(greatest, field.jet(p).gradient.norm());
    }
    return 1.5 * greatest;
}

double first_hit(const AnalyticField& field, double slope, double floor_world, const Ray& ray) {
    const Vec3d corner = Vec3d::Constant(field.half_extent_world);
    const auto [begin, end] = span_in_box(ray.origin_world, ray.direction_world, -corner, corner);
    if (!(begin < end)) return nowhere;
    const double speed = ray.direction_world.norm();
    const auto value_at = [&](double t) {
        return field.jet(ray.origin_world + t * ray.direction_world).value;
    };
    double t = begin;
    double value = value_at(t);
    const bool starts_inside = value < 0;
    while (t < end) {
        const double next =
            std::min(end, t + std::max(std::abs(value) / slope, floor_world) / speed);
        const double next_value = value_at(next);
        if ((next_value < 0) != starts_inside) {
            double lo = t;
            double hi = next;
            // 60 halvings: to the last bit of what t can hold.
            for (int i = 0; i < 60; ++i) {
                const double middle = 0.5 * (lo + hi);
                ((value_at(middle) < 0) == starts_inside ? lo : hi) = middle;
            }
            return 0.5 * (lo + hi);
        }
        t = next;
        value = next_value;
    }
    return nowhere;
}

} // namespace

void for_each_pixel(const View& view, const std::function<void(std::size_t pixel)>& at,
                    const Progress& progress) {
    std::atomic<int> rows = 0;
    const auto width = static_cast<std::size_t>(view.width);
    tbb::parallel_for(0, view.height, [&](int y) {
        for (std::size_t x = 0; x < width; ++x) at(static_cast<std::size_t>(y) * width + x);
        if (progress) progress("comparing", double(++rows) / view.height);
    });
}

Truth truth_of(const AnalyticField& field, double detail_world, const View& view,
               const Progress& progress) {
    Truth truth{.source = fmt::format("closed form of {}", field.name)};
    const double slope = greatest_slope(field);
    truth.hits.resize(view.pixel_count());
    for_each_pixel(
        view,
        [&](std::size_t pixel) {
            truth.hits[pixel] = first_hit(field, slope, detail_world / 64, view.ray(pixel));
        },
        progress);
    truth.jet = field.jet;
    // To second order in the distance, which is all that is asked of points so near.
    truth.distance_world = [jet = field.jet](const Vec3d& p_world, std::size_t) {
        const Jet there = jet(p_world);
        return std::abs(there.value) / there.gradient.norm();
    };
    truth.normal = [jet = field.jet](const Vec3d& p_world, std::size_t) -> Vec3d {
        return jet(p_world).gradient.normalized();
    };
    return truth;
}

Truth truth_of(const Primitives& primitives, const View& view) {
    const auto seen = std::make_shared<const std::vector<SeenPrimitive>>(
        cast_primitives(primitives, view.camera, view.width, view.height));
    Truth truth{.source = "rays against primitives in double"};
    for (const SeenPrimitive& hit : *seen) truth.hits.push_back(hit.t);
    truth.distance_world = [seen, view](const Vec3d& p_world, std::size_t pixel) {
        const SeenPrimitive& hit = (*seen)[pixel];
        const Ray ray = view.ray(pixel);
        return std::abs(hit.normal.dot(p_world - ray.origin_world - hit.t * ray.direction_world));
    };
    truth.normal = [seen](const Vec3d&, std::size_t pixel) { return (*seen)[pixel].normal; };
    return truth;
}

Truth truth_of(const CheckedMesh& mesh, const ExactDistance& distance, const View& view,
               const Progress& progress) {
    if (progress) progress("casting rays at triangles", 0);
    Primitives triangles;
    triangles.meshes.push_back(
        {.vertices_world = mesh.mesh.vertices_world, .triangles = mesh.mesh.triangles});
    Truth truth = truth_of(triangles, view);
    truth.source = "rays and distances to the mesh in double";
    truth.distance_world = [&distance](const Vec3d& p_world, std::size_t) {
        ExactDistance::Hint hint = 0;
        return std::abs(distance.at(p_world, hint).distance);
    };
    return truth;
}

} // namespace isocast
