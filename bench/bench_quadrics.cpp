// Spheres, sticks and other primitives: seconds a frame, and pixels that differ from a double ray
// caster. SPDX-License-Identifier: MPL-2.0
#include "peers/peer_frame.h"
#include "peers/spheres_peer.h"
#include "quadrics/molecule_styles.h"
#include "raycaster/primitives_reference.h"
#include "raycaster/renderer.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <glad/gl.h>

#include <chrono>
#include <functional>
#include <map>
#include <random>

namespace {

using namespace isocast;

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";
const std::filesystem::path shared_data =
    std::filesystem::path(ISOCAST_SOURCE_DIR) / "../shared/data";
constexpr int width = 1024;
constexpr int height = 768;

using Random = std::mt19937;

double uniform(Random& random, double lo, double hi) {
    return std::uniform_real_distribution(lo, hi)(random);
}

Vec3d in_ball(Random& random) {
    for (;;) {
        const double x = uniform(random, -1, 1);
        const double y = uniform(random, -1, 1);
        const Vec3d p(x, y, uniform(random, -1, 1));
        if (p.norm() < 1) return p;
    }
}

Vec3d some_colour(Random& random) {
    const double r = uniform(random, 0.2, 1);
    const double g = uniform(random, 0.2, 1);
    return {r, g, uniform(random, 0.2, 1)};
}

/// Spheres of one size at random in a ball, so many and so large that a ray through the middle of
/// the picture of the ball meets `depth` of them on average over the ball's disc.
Primitives ball_of_spheres(int count, double depth) {
    Random random(1);
    Primitives primitives;
    for (int i = 0; i < count; ++i)
        primitives.spheres.push_back({.centre_world = in_ball(random),
                                      .radius_world = std::sqrt(depth / count),
                                      .colour = some_colour(random)});
    return primitives;
}

/// Atoms on a shaken lattice in a ball, each bonded to three neighbours where they are there too:
/// about two half sticks for each atom and each bond's end.
Primitives ball_of_sticks(int atoms) {
    Random random(2);
    const double spacing = std::cbrt(4.0 / 3 * std::acos(-1.0) / atoms);
    const int n = static_cast<int>(1 / spacing) + 1;
    std::map<std::array<int, 3>, std::pair<Vec3d, Vec3d>> places; // and colours
    for (int z = -n; z <= n; ++z)
        for (int y = -n; y <= n; ++y)
            for (int x = -n; x <= n; ++x) {
                const Vec3d p = spacing * (Vec3d(x, y, z) + 0.2 * in_ball(random));
                if (p.norm() < 1) places[{x, y, z}] = {p, some_colour(random)};
            }
    Primitives primitives;
    for (const auto& [at, atom] : places) {
        primitives.spheres.push_back(
            {.centre_world = atom.first, .radius_world = 0.25 * spacing, .colour = atom.second});
        const int axis = std::uniform_int_distribution(0, 2)(random);
        auto next = at;
        ++next[static_cast<std::size_t>(axis)];
        const auto other = places.find(next);
        if (other == places.end()) continue;
        const Vec3d middle = (atom.first + other->second.first) / 2;
        for (const auto& [end, colour] : {atom, other->second})
            primitives.cylinders.push_back({.a_world = end,
                                            .b_world = middle,
                                            .radius_world = 0.1 * spacing,
                                            .colour = colour});
    }
    return primitives;
}

Primitives molecule(const char* file, MoleculeStyle style) {
    const MoleculePrimitives drawn =
        primitives_of(read_molecule(shared_data / file), {.style = style});
    return {.spheres = drawn.spheres, .cylinders = drawn.sticks};
}

struct BenchScene {
    std::string name;
    std::function<Primitives()> make;
};

Camera camera_of(Renderer& renderer) {
    return frame_box(renderer.surface_points_world(), {0.3, 0.4, 1}, double(width) / height, 30);
}

struct Frame {
    double seconds;
    FrameReport report;
};

Frame draw(Renderer& renderer, const Camera& camera) {
    const auto start = std::chrono::steady_clock::now();
    FrameReport report = renderer.draw(camera, width, height, {FrameImage::Beauty});
    glFinish();
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
            std::move(report)};
}

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
                const Frame drawn = draw(renderer, moved);
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

/// Colours that halves hold exactly.
Vec3d colour_of_number(int number) {
    return {double(number & 1023), double(number >> 10 & 1023), 0};
}

/// Pixels that show another primitive than the double ray caster's.
int wrong_pixels(Renderer& renderer, Primitives primitives, const Camera& camera) {
    int number = 0;
    for (Sphere& sphere : primitives.spheres) sphere.colour = colour_of_number(number++);
    for (Cylinder& stick : primitives.cylinders) stick.colour = colour_of_number(number++);
    renderer.load({.primitives = std::make_shared<Primitives>(primitives)});
    renderer.draw(camera, width, height, {FrameImage::SplatColour});
    const Image drawn = renderer.read(FrameImage::SplatColour);
    const std::vector<SeenPrimitive> seen = cast_primitives(primitives, camera, width, height);
    int wrong = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const float* rgba = &drawn.rgba[4 * i];
        const int shown =
            rgba[3] == 0 ? -1 : static_cast<int>(rgba[0]) + 1024 * static_cast<int>(rgba[1]);
        wrong += shown != seen[i].number;
    }
    return wrong;
}

/// Spheres at the picture's borders and corners, and some that the eye's plane cuts.
void count_hard_errors(Renderer& renderer) {
    for (const double fov : {60.0, 90.0}) {
        Camera camera{.eye_world = {0, 0, 5}, .fov_y_degrees = fov};
        const double top = camera.half_height_at(5);
        Primitives spheres;
        for (const double y : {-1.0, 0.0, 1.0})
            for (const double x : {-4.0 / 3, 0.0, 4.0 / 3})
                spheres.spheres.push_back(
                    {.centre_world = {x * top, y * top, 0}, .radius_world = 0.2 * top});
        fmt::print("spheres at the borders and corners, fov {}: {} wrong pixels\n", fov,
                   wrong_pixels(renderer, spheres, camera));
    }
    const Primitives cut{.spheres = {{.centre_world = {0.9, 0, 5.1}, .radius_world = 0.5},
                                     {.centre_world = {-0.8, 0.2, 4.9}, .radius_world = 0.6},
                                     {.centre_world = {0, 0.1, 5.3}, .radius_world = 4}}};
    fmt::print("spheres across the eye's plane and around the eye: {} wrong pixels\n",
               wrong_pixels(renderer, cut, {.eye_world = {0, 0, 5}}));
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
    std::string backend = "osmesa";
    app.add_option("--backend", backend, "auto, egl, osmesa");
    CLI11_PARSE(app, argc, argv);

    const std::vector<BenchScene> scenes{
        {"1tii space-filling", [] { return molecule("1tii.pdb", MoleculeStyle::SpaceFilling); }},
        {"1tii balls and sticks",
         [] { return molecule("1tii.pdb", MoleculeStyle::BallsAndSticks); }},
        {"52 k spheres in a ball", [] { return ball_of_spheres(52000, 45); }},
        {"99 k + 198 k", [] { return ball_of_sticks(99000); }}};
    const auto context = gl::make_context({.backend = gl::backend_from_name(backend)});
    Renderer renderer(*context, shader_folder);
    for (const BenchScene& scene : scenes) {
        if (scene.name.find(only) == std::string::npos) continue;
        const auto primitives = std::make_shared<Primitives>(scene.make());
        renderer.load({.primitives = primitives});
        fmt::print("{}: {} spheres, {} cylinders\n", scene.name, primitives->spheres.size(),
                   primitives->cylinders.size());
        time_looks(renderer, repeats, is_plain);
        const Camera camera = camera_of(renderer);
        if (has_peers) time_peers(renderer, *primitives, camera, repeats);
        if (counts_errors)
            fmt::print("  wrong pixels: {}\n", wrong_pixels(renderer, *primitives, camera));
    }
    if (counts_errors) count_hard_errors(renderer);
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "bench_quadrics: {}\n", error.what());
    return 1;
}
