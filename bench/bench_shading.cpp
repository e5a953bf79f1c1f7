// What each effect costs beside plain shading, as whole frames in turns.
// SPDX-License-Identifier: MPL-2.0
#include "peers/peer_frame.h"
#include "raycast/raycast_bench.h"
#include "volume/errors.h"
#include "volume/files.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>

namespace {

using namespace isocast;

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

/// A row of the table.
struct Effect {
    std::string name;
    Look look;
    Renderer* renderer;
};

/// Look with one light from the upper left; one in view space moves with the camera, so that its
/// shadow map is drawn in each frame.
Look lit(Shadow shadow, bool moves_with_camera) {
    Look look;
    look.lights = {{.direction = {-0.5, 1, 0.8},
                    .is_in_view_space = moves_with_camera,
                    .shadow = shadow,
                    .size_degrees = 5}};
    return look;
}

Look occluded(int rays) {
    Look look = lit(Shadow::None, true);
    look.effects.occlusion = {.strength = 1, .rays = rays};
    return look;
}

/// Plain shading and one effect, under a light that costs no more than the plain one.
Look with(const std::function<void(Look&)>& change) {
    Look look = lit(Shadow::None, true);
    change(look);
    return look;
}

/// The shaders, but with 64 samples for every pixel that faces the light.
std::filesystem::path shaders_without_penumbra_test() {
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / "isocast_bench_shading";
    std::filesystem::remove_all(folder);
    std::filesystem::copy(shader_folder, folder, std::filesystem::copy_options::recursive);
    const std::filesystem::path file = folder / "shading/shadow/shadow.frag";
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    std::string source = text.str();
    const std::string test = "is_hidden && nearest_gap <= reach(lowest)";
    const std::size_t at = source.find(test);
    if (at == std::string::npos) throw InputError("shadow.frag has another test for penumbras");
    std::ofstream(file) << source.replace(at, test.size(), "true");
    return folder;
}

struct Taken {
    std::vector<double> seconds;
    std::map<std::string, std::vector<double>> of_pass; // milliseconds
};

/// The effects in turns. The eye moves a little from frame to frame.
std::vector<Taken> draw_in_turns(const std::vector<Effect>& effects, const Camera& camera, int size,
                                 int repeats) {
    std::vector<Taken> taken(effects.size());
    for (int turn = 0; turn < repeats; ++turn)
        for (std::size_t i = 0; i < effects.size(); ++i) {
            effects[i].renderer->set_look(effects[i].look);
            for (int frame = 0; frame < 2; ++frame) { // the first one warms up
                Camera moved = camera;
                moved.eye_world +=
                    1e-3 * (2 * turn + frame) * (camera.eye_world - camera.target_world);
                moved.up = (camera.up + 1e-3 * (2 * turn + frame) * Vec3d::UnitX()).normalized();
                FrameReport report;
                const double seconds = frame_seconds(*effects[i].renderer, moved, size, report);
                if (frame == 0) continue;
                taken[i].seconds.push_back(seconds);
                for (const PassReport& pass : report.passes)
                    if (pass.ran && pass.drawn_by.empty())
                        taken[i].of_pass[pass.name].push_back(pass.milliseconds);
            }
        }
    return taken;
}

void print_counts(Renderer& renderer, const Look& look, const Camera& camera, int size) {
    renderer.set_look(look);
    renderer.draw(camera, size, size, {FrameImage::Shadow, FrameImage::Hit});
    const Image hit = renderer.read(FrameImage::Hit);
    const Image shadow = renderer.read(FrameImage::Shadow);
    std::map<int, int> pixels; // by samples
    for (std::size_t i = 0; i < hit.rgba.size(); i += 4)
        if (hit.rgba[i + 3] != 0) ++pixels[static_cast<int>(shadow.rgba[i + 1])];
    fmt::print("soft shadows: samples a pixel: none {} pixels, 8 {}, 64 {}\n", pixels[0], pixels[8],
               pixels[64]);
}

} // namespace

int main(int argc, char** argv) try {
    CLI::App app("What each effect costs beside plain shading");
    std::string name = "gyroid";
    int size = 512;
    int repeats = 5;
    app.add_option("FIELD", name, "a built-in field (at 128^3) or a file");
    app.add_option("--size", size);
    app.add_option("--repeats", repeats);
    std::string backend = "osmesa";
    app.add_option("--backend", backend, "auto, egl, osmesa");
    CLI11_PARSE(app, argc, argv);

    const Scene scene{.field = is_field_file(name) ? read_field(name)
                                                   : sampled(builtin_field(name), 128)};
    const auto context = gl::make_context({.backend = gl::backend_from_name(backend)});
    Renderer renderer(*context, shader_folder);
    Renderer without_test(*context, shaders_without_penumbra_test());
    renderer.load(scene);
    without_test.load(scene);
    const Camera camera = frame_box(renderer.surface_box_world(), {0.45, 0.35, 1}, 1, 30);

    const Look soft = lit(Shadow::Soft, true);
    const std::vector<Effect> effects{
        {"plain", lit(Shadow::None, true), &renderer},
        {"flat", with([](Look& look) { look.model = ShadingModel::Flat; }), &renderer},
        {"tones (Gooch)", with([](Look& look) { look.model = ShadingModel::Gooch; }), &renderer},
        {"solid texture", with([](Look& look) { look.effects.solid_texture.strength = 1; }),
         &renderer},
        {"curvature colour", with([](Look& look) { look.effects.curvature_colour.strength = 1; }),
         &renderer},
        {"curvature map", with([](Look& look) { look.effects.curvature_map.strength = 1; }),
         &renderer},
        {"accessibility", with([](Look& look) { look.effects.accessibility.strength = 1; }),
         &renderer},
        {"reflection", with([](Look& look) { look.effects.reflection.strength = 1; }), &renderer},
        {"refraction", with([](Look& look) { look.effects.refraction.strength = 1; }), &renderer},
        {"contours", with([](Look& look) { look.effects.contours.strength = 1; }), &renderer},
        {"ridges", with([](Look& look) { look.effects.ridges.strength = 1; }), &renderer},
        {"uncertainty", with([](Look& look) { look.effects.uncertainty.strength = 1; }), &renderer},
        {"flow", with([](Look& look) { look.effects.flow.strength = 1; }), &renderer},
        {"outlines", with([](Look& look) { look.effects.outlines.strength = 1; }), &renderer},
        {"hard shadows", lit(Shadow::Hard, true), &renderer},
        {"soft shadows", soft, &renderer},
        {"soft shadows, 64 samples everywhere", soft, &without_test},
        {"soft shadows, map kept", lit(Shadow::Soft, false), &renderer},
        {"ambient occlusion, 4 rays", occluded(4), &renderer},
        {"ambient occlusion, 16 rays", occluded(16), &renderer},
        {"ambient occlusion, 64 rays", occluded(64), &renderer},
    };
    const std::vector<Taken> taken = draw_in_turns(effects, camera, size, repeats);
    const double plain = median(taken[0].seconds);
    fmt::print("{} at {}x{}, {}, median of {}\n", name, size, size, context->driver().renderer,
               repeats);
    fmt::print("{:<36} {:>8} {:>9}  shares of the passes\n", "", "ms", "of plain");
    for (std::size_t i = 0; i < effects.size(); ++i) {
        double all = 0;
        for (const auto& [pass, ms] : taken[i].of_pass) all += median(ms);
        std::string shares;
        for (const auto& [pass, ms] : taken[i].of_pass)
            shares += fmt::format(" {} {:.0f} %", pass, 100 * median(ms) / all);
        const double seconds = median(taken[i].seconds);
        fmt::print("{:<36} {:>8.1f} {:>9.2f} {}\n", effects[i].name, 1e3 * seconds, seconds / plain,
                   shares);
    }
    const auto taken_by = [&](const char* effect) -> const Taken& {
        return taken[static_cast<std::size_t>(std::ranges::find(effects, effect, &Effect::name) -
                                              effects.begin())];
    };
    const Taken& with_test = taken_by("soft shadows");
    const Taken& all_samples = taken_by("soft shadows, 64 samples everywhere");
    const auto speed_up = [&](double with, double without) { return 100 * (without / with - 1); };
    fmt::print(
        "the test for penumbras makes frames {:.0f} % faster, the pass itself {:.0f} %\n",
        speed_up(median(with_test.seconds), median(all_samples.seconds)),
        speed_up(median(with_test.of_pass.at("shadow")), median(all_samples.of_pass.at("shadow"))));
    print_counts(renderer, soft, camera, size);
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "bench_shading: {}\n", error.what());
    return 1;
}
