// Tables 7.2 and 7.3 of the thesis.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/quadrics_bench.h"

#include "peers/peer_frame.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <chrono>

namespace isocast {

namespace {

/// Seconds of a frame, and of the pass that draws the splats.
struct SplatTimes {
    double frame;
    double pass;
};

SplatTimes time_splats(Renderer& renderer, const Camera& camera, int repeats) {
    std::vector<double> frame;
    std::vector<double> pass;
    for (int turn = 0; turn <= repeats; ++turn) {
        const TimedFrame drawn = draw(renderer, camera, specimens_width, specimens_height);
        if (turn == 0) continue; // it warms up
        frame.push_back(drawn.seconds);
        for (const PassReport& one : drawn.report.passes)
            if (one.name == "splat surfaces") pass.push_back(1e-3 * one.milliseconds);
    }
    return {median(frame), median(pass)};
}

SplatFragments count(Renderer& renderer, const Camera& camera) {
    renderer.set_study({.counts_fragments = true});
    const FrameReport report =
        renderer.draw(camera, specimens_width, specimens_height, {FrameImage::Splat});
    renderer.set_study({});
    return report.splat_fragments.value();
}

/// The GL's own points, lit in each fragment; seconds.
double time_points(const std::vector<Eigen::Vector2f>& centres_pixels, double radius_pixels,
                   int repeats) {
    const std::filesystem::path root = ISOCAST_SOURCE_DIR;
    gl::ShaderLibrary shaders({root / "shaders", root / "bench"});
    const auto no_vertices = gl::VertexArray::without_attributes("no vertices");
    const gl::Buffer buffer(std::as_bytes(std::span(centres_pixels)), "points");
    const gl::BufferTexture centres(buffer, gl::Format::Rg32f, "points");
    const auto image =
        gl::Texture::image(gl::Format::Rgba16f, specimens_width, specimens_height, "points");
    const auto depth =
        gl::Texture::image(gl::Format::Depth32f, specimens_width, specimens_height, "depth");
    const gl::Framebuffer target({&image}, "points", &depth);
    const gl::Program& program =
        shaders.program({{"quadrics/points.vert", "quadrics/points.frag"}, {{"LIGHTS", "1"}}});
    program.set("u_clip_from_pixel",
                Eigen::Vector2f(2.0F / specimens_width, 2.0F / specimens_height));
    program.set("u_point_pixels", static_cast<float>(2 * radius_pixels));
    program.set("u_light_directions[0]", Eigen::Vector3f(-0.3F, 0.5F, 0.8F));
    program.set("u_light_colours[0]", Eigen::Vector3f(1, 1, 1));
    program.set("u_material", Eigen::Vector4f(0.18F, 0.82F, 0.25F, 40));
    target.bind();
    set_fixed_state();
    glEnable(GL_PROGRAM_POINT_SIZE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    centres.bind_to_unit(0);
    no_vertices.bind();
    program.use();
    std::vector<double> seconds;
    for (int turn = 0; turn <= repeats; ++turn) {
        const float zero[4] = {0, 0, 0, 0};
        const float far = 1;
        glClearBufferfv(GL_COLOR, 0, zero);
        glClearBufferfv(GL_DEPTH, 0, &far);
        glFinish();
        const auto start = std::chrono::steady_clock::now();
        glDrawArrays(GL_POINTS, 0, static_cast<int>(centres_pixels.size()));
        glFinish();
        if (turn > 0) seconds.push_back(seconds_since(start));
    }
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_PROGRAM_POINT_SIZE);
    return median(seconds);
}

struct Shown {
    SplatShading splats;
    Shadow shadow;
    double outlines;
};

double frame_seconds(Renderer& renderer, const std::shared_ptr<const Primitives>& primitives,
                     const Shown& shown, int turn) {
    Look look;
    look.lights[0].shadow = shown.shadow;
    look.effects.outlines.strength = shown.outlines;
    renderer.load({.quality = {.splats = shown.splats}, .look = look, .primitives = primitives});
    Camera camera = camera_of(renderer);
    draw(renderer, camera);                                 // it warms up
    camera.eye_world += 1e-3 * (turn + 1) * Vec3d::UnitX(); // so that the light's map is not kept
    return draw(renderer, camera).seconds;
}

} // namespace

void run_table_7_2(Renderer& renderer, int repeats) {
    constexpr double small = 5;
    constexpr double large = 100;
    fmt::print("\nThesis table 7.2: primitives a second, {0} pixels in radius, in a picture of "
               "{1} x {2}; fragments that hit a second, {3} pixels in radius\n"
               "{4:<14} {5:>7} {6:>12} {6:>12} {7:>10} {8:>10} {9:>12}\n"
               "{10:<14} {10:>7} {11:>12} {12:>12} {13:>10} {13:>10} {12:>12}\n",
               small, specimens_width, specimens_height, large, "", "count", "primitives/s",
               "rasterised", "hit", "fragments/s", "", "frame", "splat pass", "each");
    Specimens of_points[2];
    for (std::size_t k = 0; k < specimen_names.size(); ++k) {
        const Specimens few = specimens(static_cast<Specimen>(k), large);
        renderer.load({.primitives = std::make_shared<Primitives>(few.primitives)});
        const double large_hits = double(count(renderer, few.camera).hit);
        const double fragment_seconds = time_splats(renderer, few.camera, repeats).pass;
        const Specimens many = specimens(static_cast<Specimen>(k), small);
        renderer.load({.primitives = std::make_shared<Primitives>(many.primitives)});
        const SplatFragments fragments = count(renderer, many.camera);
        const SplatTimes times = time_splats(renderer, many.camera, repeats);
        const auto n = double(many.centres_pixels.size());
        fmt::print("{:<14} {:>7} {:>10.2f} M {:>10.2f} M {:>10.1f} {:>10.1f} {:>10.1f} M\n",
                   specimen_names[k], n, 1e-6 * n / times.frame, 1e-6 * n / times.pass,
                   double(fragments.rasterised) / n, double(fragments.hit) / n,
                   1e-6 * large_hits / fragment_seconds);
        std::fflush(stdout);
        of_points[0] = many;
        of_points[1] = few;
    }
    const auto n = double(of_points[0].centres_pixels.size());
    const double each = 4 * small * small;
    const double large_fragments = 4 * large * large * double(of_points[1].centres_pixels.size());
    fmt::print("{:<14} {:>7} {:>12} {:>10.2f} M {:>10.1f} {:>10.1f} {:>10.1f} M\n", "points", n, "",
               1e-6 * n / time_points(of_points[0].centres_pixels, small, repeats), each, each,
               1e-6 * large_fragments / time_points(of_points[1].centres_pixels, large, repeats));
}

void run_table_7_3(Renderer& renderer, const std::string& only, int repeats) {
    constexpr std::array shown{Shown{SplatShading::Direct, Shadow::None, 0},
                               Shown{SplatShading::Direct, Shadow::Soft, 0},
                               Shown{SplatShading::Deferred, Shadow::None, 0},
                               Shown{SplatShading::Deferred, Shadow::Soft, 0},
                               Shown{SplatShading::Deferred, Shadow::Soft, 1}};
    fmt::print("\nThesis table 7.3: frames a second, {} x {}; SM: soft shadows, SL: outlines\n"
               "{:<24} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n",
               width, height, "", "", "", "direct", "direct", "deferred", "deferred", "deferred");
    fmt::print("{:<24} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "scene", "spheres",
               "cylinders", "Phong", "+ SM", "Phong", "+ SM", "+ SM + SL");
    for (const BenchScene& scene : bench_scenes(only)) {
        const auto primitives = std::make_shared<const Primitives>(scene.make(false));
        std::array<std::vector<double>, shown.size()> seconds;
        for (int turn = 0; turn < repeats; ++turn) // in turns, so that a machine's drift is in all
            for (std::size_t i = 0; i < shown.size(); ++i)
                seconds[i].push_back(frame_seconds(renderer, primitives, shown[i], turn));
        fmt::print("{:<24} {:>9} {:>9}", scene.name, primitives->spheres.size(),
                   primitives->cylinders.size());
        for (const std::vector<double>& of_one : seconds)
            fmt::print(" {:>9.2f}", 1 / median(of_one));
        fmt::print("\n");
        std::fflush(stdout);
    }
}

} // namespace isocast
