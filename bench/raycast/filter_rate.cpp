// What a filter costs by itself, as in thesis section 5.4.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/raycast_bench.h"

#include "gl/program.h"
#include "peers/peer_frame.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <cmath>
#include <map>

namespace isocast {

namespace {

constexpr int extent = 64; // bench/raycast/filter_rate.frag
constexpr int size = 256;  // pixels along each side
constexpr int samples = 256;

std::vector<float> waves() {
    std::vector<float> values;
    for (int z = 0; z < extent; ++z)
        for (int y = 0; y < extent; ++y)
            for (int x = 0; x < extent; ++x)
                values.push_back(static_cast<float>(std::sin(0.3 * x + 0.2 * y - 0.25 * z)));
    return values;
}

/// A texel holds the four samples from its own on.
std::vector<float> rows_of_four(const std::vector<float>& values) {
    std::vector<float> rows;
    for (std::size_t i = 0; i < values.size(); ++i)
        for (std::size_t k = 0; k < 4; ++k)
            rows.push_back(values[std::min(i + k, values.size() - 1)]);
    return rows;
}

struct Method {
    const char* name;
    int method;
    int kernel;
    int fetch;
};

} // namespace

void run_filter_rate(int repeats) {
    const std::filesystem::path root = ISOCAST_SOURCE_DIR;
    gl::ShaderLibrary shaders({root / "shaders", root / "bench"});
    const auto no_vertices = gl::VertexArray::without_attributes("no vertices");
    const std::vector<float> values = waves();
    const std::vector<float> rows = rows_of_four(values);
    const gl::Buffer one_buffer(std::as_bytes(std::span(values)), "samples");
    const gl::Buffer row_buffer(std::as_bytes(std::span(rows)), "rows");
    const gl::BufferTexture ones(one_buffer, gl::Format::R32f, "samples");
    const gl::BufferTexture fours(row_buffer, gl::Format::Rgba32f, "rows");
    auto volume =
        gl::Texture::volume(gl::Format::R32f, extent, extent, extent, gl::Filter::Linear, "volume");
    volume.upload_box(0, 0, 0, extent, extent, extent, std::as_bytes(std::span(values)));
    const auto image = gl::Texture::image(gl::Format::Rgba32f, size, size, "sums");
    const gl::Framebuffer target({&image}, "sums");

    constexpr std::array methods{Method{"trilinear, the GL's own filter", 2, 0, 1},
                                 Method{"trilinear, rows", 0, 0, 0},
                                 Method{"trilinear, samples", 0, 0, 1},
                                 Method{"tricubic, rows", 0, 1, 0},
                                 Method{"tricubic, samples", 0, 1, 1},
                                 Method{"tricubic, linear", 0, 1, 2},
                                 Method{"trilinear with slope, rows", 1, 0, 0},
                                 Method{"tricubic with slope, rows", 1, 1, 0},
                                 Method{"tricubic with slope, linear", 1, 1, 2}};
    std::map<std::string, std::vector<double>> taken;
    for (int turn = 0; turn < repeats; ++turn)
        for (const Method& m : methods) {
            const bool is_atlas = m.fetch == 2;
            std::map<std::string, std::string> defines =
                fetch_defines({.fetch = static_cast<Fetch>(m.fetch)});
            defines["METHOD"] = std::to_string(m.method);
            defines["KERNEL"] = std::to_string(m.kernel);
            defines["ROW_STRIDE"] = std::to_string(is_atlas ? atlas_row : extent);
            defines["PLANE_STRIDE"] = std::to_string(is_atlas ? atlas_plane : extent * extent);
            defines["SAMPLE_ZERO"] = "0.0";
            const gl::Program& program = shaders.program(
                {{"raycast/whole_picture.vert", "raycast/filter_rate.frag"}, defines});
            if (is_atlas)
                volume.bind_to_unit(1);
            else
                (m.fetch == 0 ? fours : ones).bind_to_unit(1);
            volume.bind_to_unit(5);
            program.set("u_samples", samples);
            program.set("u_from_pixel", 40.0F / size);
            program.use();
            target.bind();
            no_vertices.bind();
            glDisable(GL_BLEND);
            glDisable(GL_DEPTH_TEST);
            const auto draw = [] {
                glDrawArrays(GL_TRIANGLES, 0, 3);
                glFinish();
            };
            draw();
            const auto start = std::chrono::steady_clock::now();
            draw();
            taken[m.name].push_back(seconds_since(start));
        }
    fmt::print("\nFilters alone, {} samples; thesis 5.4: bicubic at 36 % of bilinear\n"
               "{:<32} {:>10} {:>10} {:>14}\n",
               size * size * samples, "", "ns median", "least", "rate of the GL's");
    const double trilinear = timing_of(taken[methods[0].name]).median;
    for (const Method& m : methods) {
        const Timing t = timing_of(taken[m.name]);
        constexpr double to_ns = 1e9 / (double{size} * size * samples);
        fmt::print("{:<32} {:>10.2f} {:>10.2f} {:>12.0f} %\n", m.name, t.median * to_ns,
                   t.least * to_ns, 100 * trilinear / t.median);
    }
}

} // namespace isocast
