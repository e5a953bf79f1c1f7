// SLIM surfaces: fragments beside spheres', and frames with and without back-face culling (tables 1
// and 2 of Stoll et al. 2006).
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/quadrics_bench.h"
#include "quadrics/slim_file.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace {

using namespace isocast;

double median(std::vector<double> values) {
    std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
    return values[values.size() / 2];
}

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

void run_fragments(Renderer& renderer, int repeats) {
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
            fmt::print("{:<30} {:>7} {:>10} {:>10} {:>8.1f}\n", name, primitives.count(),
                       fragments.rasterised, fragments.hit,
                       1e6 * ms / double(fragments.rasterised));
        }
    }
}

double seconds_of(Renderer& renderer, int w, int h, int repeats) {
    Camera camera = frame_box(renderer.surface_points_world(), {0.3, 0.4, 1}, double(w) / h, 30);
    std::vector<double> seconds;
    for (int frame = 0; frame <= repeats; ++frame) {
        camera.eye_world.x() *= 1 + 1e-4;
        const TimedFrame drawn = draw(renderer, camera, w, h);
        if (frame > 0) seconds.push_back(drawn.seconds); // the first one warms up
    }
    return median(seconds);
}

void run_frames(Renderer& renderer, const std::vector<std::string>& paths, int repeats) {
    fmt::print("table 2: frames a second\n{:<24} {:>8} {:<8} {:>10} {:>10} {:>10}  "
               "1e6 pieces a second at 2x2\n",
               "model", "pieces", "culling", "1024x1280", "512x512", "2x2");
    for (const std::string& path : paths) {
        SlimSurface surface = read_slim(path);
        const bool is_closed = surface.is_closed;
        std::array<std::array<double, 2>, 2> seconds{};
        for (const bool culls : {true, false}) {
            if (culls && !is_closed) continue;
            surface.is_closed = culls;
            const std::size_t pieces = surface.levels.front().patches.size();
            // One level alone: what is compared is drawn at any size.
            SlimSurface finest = surface;
            finest.levels.resize(1);
            renderer.load({.primitives = std::make_shared<Primitives>(
                               Primitives{.slims = {std::move(finest)}})});
            const double large = seconds_of(renderer, 1280, 1024, repeats);
            const double small = seconds_of(renderer, 512, 512, repeats);
            const double tiny = seconds_of(renderer, 2, 2, repeats);
            seconds[culls ? 0 : 1] = {large, small};
            fmt::print("{:<24} {:>8} {:<8} {:>10.2f} {:>10.2f} {:>10.1f} {:>8.2f}\n",
                       std::filesystem::path(path).stem().string(), pieces, culls ? "yes" : "no",
                       1 / large, 1 / small, 1 / tiny, double(pieces) / tiny / 1e6);
        }
        if (is_closed)
            fmt::print("{:<24} culling makes frames {:.2f} and {:.2f} times as fast\n", "",
                       seconds[1][0] / seconds[0][0], seconds[1][1] / seconds[0][1]);
    }
}

} // namespace

int main(int argc, char** argv) try {
    CLI::App app("What SLIM surfaces cost");
    int repeats = 5;
    std::vector<std::string> paths;
    app.add_option("SLIM", paths, "Files: isocast convert MESH -o FILE.slim");
    app.add_option("--repeats", repeats);
    CLI11_PARSE(app, argc, argv);
    const auto context = gl::make_context({.backend = gl::Backend::Osmesa});
    Renderer renderer(*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders");
    run_fragments(renderer, repeats);
    run_frames(renderer, paths, repeats);
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "bench_slim_frames: {}\n", error.what());
    return 1;
}
