// What fitting a texture budget by coarser bricks costs in accuracy, and by streaming in time.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/raycast_bench.h"

#include "peers/peer_frame.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace isocast {

namespace {

/// Hits and normals against those of the picture at full resolution.
struct Difference {
    int pixels = 0;                        // that one of the two hits
    double hit_rms = 0, hit_max = 0;       // voxels along the ray
    double normal_rms = 0, normal_max = 0; // degrees
};

Difference difference(const Image& hits, const Image& normals, const Image& exact_hits,
                      const Image& exact_normals, double voxel_size) {
    Difference d;
    int count = 0;
    for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
        const auto at = [i](const Image& image) {
            return Vec3d(image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]);
        };
        if (hits.rgba[i + 3] != exact_hits.rgba[i + 3]) ++d.pixels;
        if (hits.rgba[i + 3] == 0 || exact_hits.rgba[i + 3] == 0) continue;
        ++count;
        const double off = (at(hits) - at(exact_hits)).norm() / voxel_size;
        const Vec3d n = at(normals);
        const Vec3d m = at(exact_normals);
        const double degrees = std::atan2(n.cross(m).norm(), n.dot(m)) * 180 / std::numbers::pi;
        d.hit_rms += off * off;
        d.hit_max = std::max(d.hit_max, off);
        d.normal_rms += degrees * degrees;
        d.normal_max = std::max(d.normal_max, degrees);
    }
    d.hit_rms = std::sqrt(d.hit_rms / std::max(1, count));
    d.normal_rms = std::sqrt(d.normal_rms / std::max(1, count));
    return d;
}

} // namespace

void run_coarse(Renderer& renderer, const std::shared_ptr<const FieldSource>& field,
                const Camera& camera, int size, int repeats) {
    const ImageSet wanted{FrameImage::Hit, FrameImage::Gradient};
    const double voxel_size = field->space().voxel_size_world();
    renderer.load({.field = field});
    renderer.draw(camera, size, size, wanted);
    const Image exact_hits = renderer.read(FrameImage::Hit);
    const Image exact_normals = renderer.read(FrameImage::Gradient);
    const double all_bytes =
        double(renderer.pool().brick_count() * BrickLayout(StorageOptions{}).brick_bytes);
    fmt::print("\nTexture budget, as a part of what all bricks take ({:.1f} MB): the picture "
               "against the one at full resolution. Bricks of 8, 4, 2, 1 cells; bound of the "
               "residual [voxels]; hits along the ray [voxels]; normals [degrees]\n"
               "{:<8} {:>6} {:>8} {:>8} {:>22} {:>8} {:>8} {:>8} {:>8} {:>8} {:>7}\n",
               all_bytes / 1e6, "", "budget", "frame", "load", "bricks", "bound", "hit RMS", "max",
               "normal RMS", "max", "differ");
    for (const OverBudget over : {OverBudget::Coarsen, OverBudget::Stream}) {
        for (const double fraction : {1.0, 0.5, 0.25, 0.125}) {
            const StorageOptions storage{.budget_bytes = std::int64_t(fraction * all_bytes),
                                         .over_budget = over};
            const DrawCase draw_case{"", {.field = field, .storage = storage}};
            const DrawResult result =
                draw_in_turns(renderer, {draw_case}, camera, size, repeats).front();
            renderer.draw(camera, size, size, wanted);
            const Difference d =
                difference(renderer.read(FrameImage::Hit), renderer.read(FrameImage::Gradient),
                           exact_hits, exact_normals, voxel_size);
            const auto& coarse = renderer.coarse_bricks();
            const LevelCounts counts =
                coarse ? coarse->counts : LevelCounts{renderer.pool().brick_count()};
            fmt::print("{:<8} {:>6} {:>8.4f} {:>8.4f} {:>22} {:>8.3f} {:>8.4f} {:>8.3f} {:>8.3f} "
                       "{:>8.2f} {:>7}\n",
                       over == OverBudget::Coarsen ? "coarsen" : "stream", fraction,
                       result.frame.median, result.load.median,
                       fmt::format("{} {} {} {}", counts[0], counts[1], counts[2], counts[3]),
                       coarse ? coarse->greatest_residual / voxel_size : 0.0, d.hit_rms, d.hit_max,
                       d.normal_rms, d.normal_max, d.pixels);
            std::fflush(stdout);
        }
    }
}

} // namespace isocast
