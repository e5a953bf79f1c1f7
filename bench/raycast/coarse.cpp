// What fitting a texture budget by coarser bricks costs in accuracy, and by streaming in time.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/raycast_bench.h"

#include "filtering/reconstruct.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace isocast {

namespace {

/// A picture against the one at full resolution.
struct Difference {
    int pixels = 0; // that one of the two hits, or where hits lie farther apart than a voxel
    // Of hits from the surface at full resolution [voxels].
    double distance_rms = 0, distance_max = 0;
    // Of normals in the other pixels [degrees].
    double normal_rms = 0, normal_max = 0;
};

struct Picture {
    explicit Picture(const Renderer& renderer)
        : hits(renderer.read(FrameImage::Hit)), gradients(renderer.read(FrameImage::Gradient)) {}
    Image hits;
    Image gradients;
};

Difference difference(const Picture& picture, const Picture& exact, const Camera& camera,
                      const FieldSource& control) {
    Difference d;
    int hits = 0;
    int near = 0;
    const double voxel_size = control.space().voxel_size_world();
    for (std::size_t i = 0; i < picture.hits.rgba.size(); i += 4) {
        const auto at = [i](const Image& image) {
            return Vec3d(image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]);
        };
        const bool is_hit = picture.hits.rgba[i + 3] != 0;
        if (is_hit) {
            ++hits;
            const Vec3d p_index = control.space().to_index(camera.eye_world + at(picture.hits));
            const Jet f = tricubic_jet(control, p_index);
            const double distance = std::abs(f.value) / f.gradient.norm();
            d.distance_rms += distance * distance;
            d.distance_max = std::max(d.distance_max, distance);
        }
        if (is_hit != (exact.hits.rgba[i + 3] != 0) ||
            (at(picture.hits) - at(exact.hits)).norm() > voxel_size) {
            ++d.pixels;
            continue;
        }
        if (!is_hit) continue;
        ++near;
        const Vec3d n = at(picture.gradients);
        const Vec3d m = at(exact.gradients);
        const double degrees = std::atan2(n.cross(m).norm(), n.dot(m)) * 180 / std::numbers::pi;
        d.normal_rms += degrees * degrees;
        d.normal_max = std::max(d.normal_max, degrees);
    }
    d.distance_rms = std::sqrt(d.distance_rms / std::max(1, hits));
    d.normal_rms = std::sqrt(d.normal_rms / std::max(1, near));
    return d;
}

} // namespace

void run_coarse(Renderer& renderer, const std::shared_ptr<const FieldSource>& field,
                const Camera& camera, int size, int repeats) {
    const ImageSet wanted{FrameImage::Hit, FrameImage::Gradient};
    const double voxel_size = field->space().voxel_size_world();
    const auto control = control_samples(field, Filter::Interpolating);
    renderer.load({.field = field});
    renderer.draw(camera, size, size, wanted);
    const Picture exact(renderer);
    const double all_bytes =
        double(renderer.pool().brick_count() * BrickLayout(StorageOptions{}).brick_bytes);
    fmt::print(
        "\nTexture budget, as a part of what all bricks take ({:.1f} MB): seconds; bricks of "
        "8, 4, 2, 1 cells; bound of the residual [voxels]; distance of hits from the surface "
        "at full resolution [voxels]; normals [degrees]; differ: pixels that one of the two "
        "pictures hits, or farther apart than a voxel along the ray\n"
        "{:<8} {:>6} {:>8} {:>8} {:>20} {:>8} {:>8} {:>8} {:>8} {:>8} {:>7}\n",
        all_bytes / 1e6, "", "budget", "frame", "load", "bricks", "bound", "hit RMS", "max",
        "n. RMS", "max", "differ");
    for (const OverBudget over : {OverBudget::Coarsen, OverBudget::Stream}) {
        for (const double fraction : {1.0, 0.5, 0.25, 0.125}) {
            const StorageOptions storage{.budget_bytes = std::int64_t(fraction * all_bytes),
                                         .over_budget = over};
            const DrawCase draw_case{"", {.field = field, .storage = storage}};
            const DrawResult result =
                draw_in_turns(renderer, {draw_case}, camera, size, repeats).front();
            renderer.draw(camera, size, size, wanted);
            const Difference d = difference(Picture(renderer), exact, camera, *control);
            const auto& coarse = renderer.coarse_bricks();
            const LevelCounts counts =
                coarse ? coarse->counts : LevelCounts{renderer.pool().brick_count()};
            fmt::print("{:<8} {:>6} {:>8.4f} {:>8.4f} {:>20} {:>8.3f} {:>8.4f} {:>8.3f} {:>8.3f} "
                       "{:>8.2f} {:>7}\n",
                       over == OverBudget::Coarsen ? "coarsen" : "stream", fraction,
                       result.frame.median, result.load.median,
                       fmt::format("{} {} {} {}", counts[0], counts[1], counts[2], counts[3]),
                       coarse ? coarse->greatest_residual / voxel_size : 0.0, d.distance_rms,
                       d.distance_max, d.normal_rms, d.normal_max, d.pixels);
            std::fflush(stdout);
        }
    }
}

} // namespace isocast
