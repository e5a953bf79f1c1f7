// Every filter and storage on a torus whose surface is known.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/raycast_bench.h"

#include "filtering/filter.h"
#include "peers/peer_frame.h"
#include "raycaster/reference.h"
#include "volume/analytic_fields.h"
#include "volume/dense_field.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

namespace isocast {

AnalyticField study_torus() {
    const double middle = (study_resolution - 1) / 2.0;
    return torus_field(Vec3d(middle + 0.137, middle - 0.241, middle + 0.319), {0.3, 1, 0.5},
                       0.28 * study_resolution, 0.11 * study_resolution);
}

std::shared_ptr<const FieldSource> study_distances(double half_width) {
    const AnalyticField torus = study_torus();
    const IndexBox box{Index3::Zero(), Index3::Constant(study_resolution)};
    std::vector<float> values;
    for (int z = 0; z < study_resolution; ++z)
        for (int y = 0; y < study_resolution; ++y)
            for (int x = 0; x < study_resolution; ++x)
                values.push_back(static_cast<float>(
                    std::clamp(torus.jet(Vec3d(x, y, z)).value, -half_width, half_width)));
    return std::make_shared<DenseField>(GridSpace::uniform(1), box, std::move(values), half_width);
}

Camera study_camera() {
    const Vec3d middle = Vec3d::Constant((study_resolution - 1) / 2.0);
    return {.eye_world = middle + 2.2 * study_resolution * Vec3d(0.45, 0.35, 1).normalized(),
            .target_world = middle};
}

double degrees_between(const Vec3d& a, const Vec3d& b) {
    // By the sine: acos of nearly one would round to 0.02 degrees.
    return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

namespace {

constexpr int resolution = study_resolution;
constexpr int size = study_size;

/// Which pixels see the surface, by `hits(ray)`; true bytes for threads.
template<class Hits>
std::vector<std::uint8_t> mask(const Camera& camera, Hits hits) {
    std::vector<std::uint8_t> covered(std::size_t{size} * size);
    tbb::parallel_for(0, size, [&](int y) {
        for (int x = 0; x < size; ++x)
            covered[static_cast<std::size_t>(y * size + x)] =
                hits(camera_ray(camera, size, size, x + 0.5, y + 0.5)) ? 1 : 0;
    });
    return covered;
}

/// Marches by exact distances: the ray enters if it comes nearer than 1e-11 voxel.
bool enters(const AnalyticField& torus, const Ray& ray) {
    const Vec3d d = ray.direction_world.normalized();
    double t = 0;
    for (int i = 0; i < 4000 && t < 5 * resolution; ++i) {
        const double value = torus.jet(ray.origin_world + t * d).value;
        if (value < 1e-11) return true;
        t += value;
    }
    return false;
}

struct Accuracy {
    int hits = 0;
    int missed = 0; // of the reconstructed function's
    int false_hits = 0;
    int missed_exact = 0; // of the torus's
    int false_exact = 0;
    double hit_max = 0, hit_rms = 0;       // distance from the torus [voxels]
    double normal_max = 0, normal_rms = 0; // degrees
};

Accuracy measure(const Renderer& renderer, const AnalyticField& torus, const Camera& camera,
                 const std::vector<std::uint8_t>& reference,
                 const std::vector<std::uint8_t>& exact) {
    const Image hit = renderer.read(FrameImage::Hit);
    const Image gradient = renderer.read(FrameImage::Gradient);
    Accuracy a;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const auto i = static_cast<std::size_t>(y * size + x);
            const float* h = hit.pixel(x, y);
            const bool is_hit = h[3] != 0;
            a.missed += !is_hit && reference[i] != 0;
            a.false_hits += is_hit && reference[i] == 0;
            a.missed_exact += !is_hit && exact[i] != 0;
            a.false_exact += is_hit && exact[i] == 0;
            if (!is_hit) continue;
            ++a.hits;
            const Jet jet = torus.jet(camera.eye_world + Vec3d(h[0], h[1], h[2]));
            const float* g = gradient.pixel(x, y);
            const Vec3d n = Vec3d(g[0], g[1], g[2]).normalized();
            const double degrees = degrees_between(n, jet.gradient);
            const double off = std::abs(jet.value);
            a.hit_max = std::max(a.hit_max, off);
            a.hit_rms += off * off;
            a.normal_max = std::max(a.normal_max, degrees);
            a.normal_rms += degrees * degrees;
        }
    a.hit_rms = std::sqrt(a.hit_rms / std::max(a.hits, 1));
    a.normal_rms = std::sqrt(a.normal_rms / std::max(a.hits, 1));
    return a;
}

struct FilterCase {
    const char* name;
    Filter value;
    std::optional<Filter> derivative;
};

/// The filters by themselves, and two pairs of thesis section 6.4.4's kind.
constexpr std::array filter_cases{
    FilterCase{"interpolating", Filter::Interpolating, {}},
    FilterCase{"bspline", Filter::BSpline, {}},
    FilterCase{"catmull-rom", Filter::CatmullRom, {}},
    FilterCase{"linear", Filter::Linear, {}},
    FilterCase{"linear, interpolating gradient", Filter::Linear, Filter::Interpolating},
    FilterCase{"interpolating, bspline gradient", Filter::Interpolating, Filter::BSpline}};

} // namespace

void run_accuracy(Renderer& renderer) {
    const AnalyticField torus = study_torus();
    const Camera camera = study_camera();
    const auto exact = mask(camera, [&](const Ray& ray) { return enters(torus, ray); });
    fmt::print(
        "\nAccuracy on the exact torus, {}^3 @ {}^2. Hits: distance from the torus [voxels]; "
        "normals [degrees]; missed/false pixels against the double reference caster on the "
        "unrounded control samples, and against the torus itself\n"
        "{:<32} {:<6} {:<8} {:>6} {:>9} {:>9} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8}\n",
        resolution, size, "filter", "band", "storage", "hits", "hit RMS", "max", "normal RMS",
        "max", "missed", "false", "missed", "false");
    struct Band {
        const char* name;
        double half_width;
    };
    for (const Band& band : {Band{"none", 1e6}, Band{"3", 3}}) {
        const auto samples = study_distances(band.half_width);
        for (const FilterCase& filters : filter_cases) {
            const Filter filter = filters.value;
            // The reference evaluates all samples; beyond the extent nothing of the torus lies.
            const ReferenceCaster caster(*control_samples(samples, filter), 0,
                                         {.kernel = kernel_of(filter)});
            const auto reference =
                mask(camera, [&](const Ray& ray) { return caster.hit(ray).has_value(); });
            for (const auto& [name, format] : {std::pair{"float32", SampleFormat::Float32},
                                               std::pair{"float16", SampleFormat::Float16},
                                               std::pair{"norm16", SampleFormat::Norm16}}) {
                renderer.load({.field = samples,
                               .filter = filter,
                               .derivative_filter = filters.derivative,
                               .storage = {.format = format}});
                renderer.draw(camera, size, size, {FrameImage::Hit, FrameImage::Gradient});
                const Accuracy a = measure(renderer, torus, camera, reference, exact);
                fmt::print("{:<32} {:<6} {:<8} {:>6} {:>9.2e} {:>9.2e} {:>9.4f} {:>9.4f} {:>8} "
                           "{:>8} {:>8} {:>8}\n",
                           filters.name, band.name, name, a.hits, a.hit_rms, a.hit_max,
                           a.normal_rms, a.normal_max, a.missed, a.false_hits, a.missed_exact,
                           a.false_exact);
                std::fflush(stdout);
            }
        }
    }
}

} // namespace isocast
