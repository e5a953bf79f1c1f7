// Spheres, sticks and other primitives: seconds a frame, and pixels that differ from a double ray
// caster.
// SPDX-License-Identifier: MPL-2.0
#include "peers/peer_frame.h"
#include "peers/spheres_peer.h"
#include "quadrics/quadrics_bench.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <map>

namespace {

using namespace isocast;

void time_looks(Renderer& renderer, int repeats, bool is_plain) {
    Look plain;
    Look rich;
    rich.lights[0].shadow = Shadow::Soft;
    rich.effects.outlines.strength = 1;
    std::vector<std::pair<const char*, Look>> looks{{"plain", plain},
                                                    {"soft shadows, outlines", rich}};
    if (is_plain) looks.pop_back();
    std::map<std::string, std::vector<double>> seconds;
    std::map<std::string, std::map<std::string, std::vector<double>>> of_pass;
    const Camera camera = camera_of(renderer);
    for (int turn = 0; turn < repeats; ++turn)
        for (const auto& [name, look] : looks) {
            renderer.set_look(look);
            for (int frame = 0; frame < 2; ++frame) { // the first one warms up
                Camera moved = camera;
                moved.eye_world += 1e-3 * (2 * turn + frame) * Vec3d::UnitX();
                const TimedFrame drawn = draw(renderer, moved);
                if (frame == 0) continue;
                seconds[name].push_back(drawn.seconds);
                double all = 0;
                for (const PassReport& pass : drawn.report.passes)
                    if (pass.ran && pass.drawn_by.empty()) {
                        of_pass[name][pass.name].push_back(pass.milliseconds);
                        all += pass.milliseconds;
                    }
                of_pass[name]["before passes"].push_back(1e3 * drawn.seconds - all);
            }
        }
    for (const auto& [name, look] : looks) {
        std::string passes;
        for (const auto& [pass, ms] : of_pass[name])
            passes += fmt::format("  {} {:.1f}", pass, median(ms));
        fmt::print("  {:<24} {:>7.4f} s;  ms:{}\n", name, median(seconds[name]), passes);
    }
}

void time_peers(Renderer& renderer, const Primitives& primitives, const Camera& camera,
                int repeats) {
    renderer.draw(camera, width, height, {FrameImage::SplatColour});
    const Image drawn = renderer.read(FrameImage::SplatColour);
    std::vector<bool> covered;
    for (std::size_t i = 3; i < drawn.rgba.size(); i += 4) covered.push_back(drawn.rgba[i] != 0);
    const SpheresPeerScene scene{.primitives = primitives,
                                 .camera = camera,
                                 .width = width,
                                 .height = height,
                                 .repeats = repeats,
                                 .covered = covered};
    for (const SpheresPeerFrame& frame : spheres_peers(scene))
        fmt::print("  {:<24} {:>7.4f} s;  {}\n", frame.name, frame.seconds, frame.note);
}

} // namespace

int main(int argc, char** argv) try {
    CLI::App app("What primitives cost, and how exact their pictures are");
    std::string only;
    int repeats = 5;
    bool counts_errors = false;
    app.add_option("--only", only, "scenes with this in their names");
    app.add_option("--repeats", repeats);
    bool is_plain = false;
    app.add_flag("--plain", is_plain, "plain shading alone");
    bool has_peers = false;
    app.add_flag("--peers", has_peers, "VTK and PyMOL in the same run");
    app.add_flag("--errors", counts_errors, "also count wrong pixels");
    bool is_thesis = false;
    app.add_flag("--thesis", is_thesis,
                 "tables 7.2 and 7.3 instead, and what bounding shapes and the paper's eq. 7 cost");
    std::string backend = "osmesa";
    app.add_option("--backend", backend, "auto, egl, osmesa");
    CLI11_PARSE(app, argc, argv);

    const auto context = gl::make_context({.backend = gl::backend_from_name(backend)});
    Renderer renderer(*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders");
    if (is_thesis) {
        run_table_7_2(renderer, repeats);
        run_table_7_3(renderer, only, repeats);
        run_bounding_shapes(renderer);
        run_equation_7(renderer);
        return 0;
    }
    for (const BenchScene& scene : bench_scenes(only)) {
        const auto primitives = std::make_shared<Primitives>(scene.make(false));
        renderer.load({.primitives = primitives});
        fmt::print("{}: {} spheres, {} cylinders\n", scene.name, primitives->spheres.size(),
                   primitives->cylinders.size());
        time_looks(renderer, repeats, is_plain);
        const Camera camera = camera_of(renderer);
        if (has_peers) time_peers(renderer, scene.make(true), camera, repeats);
        if (counts_errors)
            fmt::print("  wrong pixels: {}\n", wrong_pixels(renderer, *primitives, camera));
    }
    if (counts_errors) count_hard_errors(renderer);
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "bench_quadrics: {}\n", error.what());
    return 1;
}
