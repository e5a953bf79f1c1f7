// SLIM surfaces: fragments beside spheres', and frames with and without back-face culling (tables 1
// and 2 of Stoll et al. 2006).
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/checked_mesh.h"
#include "distance_transform/mesh_files.h"
#include "quadrics/quadrics_bench.h"
#include "quadrics/slim_cover.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace {

using namespace isocast;

constexpr int size = 1024; // of pictures of specimens [pixels]

/// Milliseconds of a frame's passes, by the names that begin so; median.
double milliseconds(Renderer& renderer, const Camera& camera, const std::string& name,
                    int repeats) {
    std::vector<double> sums;
    for (int turn = 0; turn <= repeats; ++turn) {
        const FrameReport report = renderer.draw(camera, size, size, {FrameImage::Beauty});
        double sum = 0;
        for (const PassReport& pass : report.passes)
            if (pass.ran && pass.name.starts_with(name)) sum += pass.milliseconds;
        if (turn > 0) sums.push_back(sum); // the first one warms up
    }
    return median(sums);
}

/// Side by side in a square of `columns`^2, as large as their places.
template<class Put>
void put_in_rows(int columns, Put put) {
    for (int y = 0; y < columns; ++y)
        for (int x = 0; x < columns; ++x)
            put(Vec3d((x + 0.5) / columns - 0.5, (y + 0.5) / columns - 0.5, 0), 0.5 / columns,
                x + columns * y);
}

/// returns  1e6 a second, of small pieces' visibility
double run_fragments(Renderer& renderer, int repeats) {
    double fragments_per_us = 0;
    fmt::print("fragments: nanoseconds each, of those in the rectangles\n{:<30} {:>7} {:>10} "
               "{:>10} {:>8}\n",
               "", "count", "rasterised", "hit", "ns");
    const Camera camera{.eye_world = {0, 0, 3},
                        .target_world = Vec3d::Zero(),
                        .fov_y_degrees = 2 * std::atan(0.5 / 3) * 180 / std::acos(-1.0)};
    for (const int columns : {5, 50}) {
        Primitives spheres;
        Primitives pieces{.slims = {{.levels = {{{}, 1e-3}}, .is_closed = true}}};
        Primitives open{.slims = {{.levels = {{{}, 1e-3}}}}};
        put_in_rows(columns, [&](const Vec3d& centre, double radius, int i) {
            spheres.spheres.push_back({.centre_world = centre, .radius_world = radius});
            const double turn = 2.4 * i;
            const SlimPatch patch{
                .centre_world = centre,
                .radius_world = radius,
                .normal = Vec3d(0.3 * std::cos(turn), 0.3 * std::sin(turn), 1).normalized(),
                .height = {0, 0, 0, -0.3 / radius, 0.1 / radius, -0.2 / radius}};
            pieces.slims[0].levels[0].patches.push_back(patch);
            open.slims[0].levels[0].patches.push_back(patch);
        });
        for (const auto& [name, primitives, passes] :
             {std::tuple{"spheres", spheres, "splat surfaces"},
              {"SLIM, facing: visibility", pieces, "slim nearest"},
              {"SLIM, facing: blend", pieces, "slim hits"},
              {"SLIM, both sides: visibility", open, "slim nearest"},
              {"SLIM, both sides: blend", open, "slim hits"}}) {
            renderer.load({.primitives = std::make_shared<Primitives>(primitives)});
            renderer.set_study({.counts_fragments = true});
            const SplatFragments fragments =
                renderer.draw(camera, size, size, {FrameImage::Hit}).splat_fragments.value();
            renderer.set_study({});
            const double ms = milliseconds(renderer, camera, passes, repeats);
            if (name == std::string("SLIM, facing: visibility"))
                fragments_per_us = 1e-3 * double(fragments.rasterised) / ms;
            fmt::print("{:<30} {:>7} {:>10} {:>10} {:>8.1f}\n", name, primitives.count(),
                       fragments.rasterised, fragments.hit,
                       1e6 * ms / double(fragments.rasterised));
        }
    }
    return fragments_per_us;
}

double seconds_of(Renderer& renderer, int w, int h, int repeats) {
    return median_frame_seconds(
        renderer, frame_box(renderer.surface_points_world(), {0.3, 0.4, 1}, double(w) / h, 30), w,
        h, repeats);
}

/// Of a mesh, the finest level alone: what is compared is drawn at any size.
SlimSurface surface_of(const std::string& path, double max_error_share) {
    const CheckedMesh checked = check(read_mesh(path));
    const TriangleMesh mesh{.vertices_world = checked.mesh.vertices_world,
                            .triangles = checked.mesh.triangles};
    Eigen::AlignedBox3d box;
    for (const Vec3d& vertex : mesh.vertices_world) box.extend(vertex);
    std::vector<SlimReport> reports;
    return slim_of(mesh,
                   {.max_error_world = max_error_share * box.diagonal().norm(), .max_levels = 1},
                   reports);
}

/// returns  1e6 pieces of the last a second, in a picture of 2x2
double run_frames(Renderer& renderer, const std::vector<std::string>& paths, double max_error_share,
                  int repeats) {
    fmt::print("table 2, at an error of {} of the diagonal: frames a second at 1280x1024, culling "
               "and not, at 512x512, culling and not; 1e6 pieces a second at 2x2\n",
               max_error_share);
    double pieces_per_us = 0;
    for (const std::string& path : paths) {
        SlimSurface surface = surface_of(path, max_error_share);
        const std::size_t pieces = surface.patch_count();
        if (!surface.is_closed)
            throw std::runtime_error(path + ": open, so that nothing is culled");
        std::array<std::vector<double>, 2> of_large, of_small, of_tiny;
        for (int round = 0; round < 5; ++round) // in turn: machines do not stay as fast
            for (const bool culls : {true, false}) {
                surface.is_closed = culls;
                renderer.load(
                    {.primitives = std::make_shared<Primitives>(Primitives{.slims = {surface}})});
                of_large[culls].push_back(seconds_of(renderer, 1280, 1024, repeats));
                of_small[culls].push_back(seconds_of(renderer, 512, 512, repeats));
                of_tiny[culls].push_back(seconds_of(renderer, 2, 2, repeats));
            }
        const std::array large{median(of_large[0]), median(of_large[1])};
        const std::array small{median(of_small[0]), median(of_small[1])};
        const std::array tiny{median(of_tiny[0]), median(of_tiny[1])};
        pieces_per_us = 1e-6 * double(pieces) / tiny[1];
        fmt::print(
            "{} {} {:.2f} {:.2f} {:.2f} {:.2f} {:.2f}\n  culling: {:.2f} and {:.2f} times as "
            "fast\n",
            std::filesystem::path(path).stem().string(), pieces, 1 / large[1], 1 / large[0],
            1 / small[1], 1 / small[0], pieces_per_us, large[0] / large[1], small[0] / small[1]);
    }
    return pieces_per_us;
}

} // namespace

int main(int argc, char** argv) try {
    CLI::App app("What SLIM surfaces cost");
    int repeats = 9;
    std::vector<std::string> paths;
    double max_error_share = 1e-3;
    app.add_option("MESH", paths, "Closed meshes");
    app.add_option("--max-error", max_error_share, "Of the box's diagonal");
    app.add_option("--repeats", repeats);
    CLI11_PARSE(app, argc, argv);
    const auto context = gl::make_context({.backend = gl::Backend::Osmesa});
    Renderer renderer(*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders");
    const double fragments = run_fragments(renderer, repeats);
    const double pieces = run_frames(renderer, paths, max_error_share, repeats);
    fmt::print("SLIM: {:.2f} M pieces/s, {:.1f} M fragments/s\n", pieces, fragments);
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "bench_slim_frames: {}\n", error.what());
    return 1;
}
