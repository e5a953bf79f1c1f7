// What each way to fetch samples costs, in time and in accuracy.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/raycast_bench.h"

#include "raycaster/reference.h"

#include <fmt/format.h>
#include <glad/gl.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

namespace isocast {

namespace {

/// Twins of tests/shaders/field_probe.comp.
struct Probe {
    Eigen::Vector4f p_local;
    Eigen::Vector4f direction;
};
struct Probed {
    Eigen::Vector4f value_and_slope;
    Eigen::Vector4f gradient;
    Eigen::Vector4f fast;
    Eigen::Vector4f fast_gradient;
};

struct Error {
    double max = 0;
    double square = 0;
    int count = 0;

    void add(double error) {
        max = std::max(max, error);
        square += error * error;
        ++count;
    }
    double rms() const { return std::sqrt(square / std::max(count, 1)); }
};

/// Of values by the fewest fetches, at random points of active blocks [world], and the most that
/// fetch_error() allows.
struct ValueErrors {
    Error error;
    double allowed = 0;
};

ValueErrors value_errors(const FieldSource& control, const ReferenceCaster& truth,
                         const StorageOptions& storage) {
    const Kernel kernel = Kernel::BSpline;
    const BlockRanges ranges = find_block_ranges(control, kernel);
    const FieldOnGpu field(control, control, kernel, ranges, active_pages(ranges, 0), 0, storage,
                           {});
    std::mt19937 random(1);
    std::uniform_real_distribution<float> place(2, study_resolution - 3);
    std::vector<Probe> probes(100000);
    const Vec3d origin = field.local_origin_index().cast<double>();
    for (Probe& probe : probes) {
        probe.direction = Eigen::Vector4f::UnitX();
        const Vec3d p(place(random), place(random), place(random));
        probe.p_local << (p - origin).cast<float>(), 0;
    }
    std::vector<Probed> results(probes.size());
    const std::filesystem::path source = ISOCAST_SOURCE_DIR;
    gl::ShaderLibrary shaders({source / "shaders", source / "tests/shaders"});
    const gl::Program& program = shaders.program({{"field_probe.comp"}, field.pool().defines()});
    field.bind(program);
    const double unit = field.pool().world_from_stored();
    program.set("u_world_from_stored", static_cast<float>(unit));
    const gl::Buffer in(std::as_bytes(std::span(probes)), "probes");
    const gl::Buffer out(std::as_bytes(std::span(results)), "results");
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, in.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, out.id());
    program.use();
    glDispatchCompute(static_cast<GLuint>(probes.size() + 63) / 64, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(out.id(), 0, static_cast<GLsizeiptr>(results.size() * sizeof(Probed)),
                            results.data());
    ValueErrors all;
    for (std::size_t i = 0; i < probes.size(); ++i) {
        if (results[i].value_and_slope.z() == 0) continue;
        const Vec3d p = probes[i].p_local.head<3>().cast<double>() + origin;
        all.error.add(std::abs(unit * results[i].fast.x() - truth.value(p)));
        all.allowed = std::max(all.allowed, unit * results[i].fast.z());
    }
    return all;
}

struct Body {
    const char* name;
    StorageOptions storage;
};

} // namespace

void run_fetches(Renderer& renderer, int repeats) {
    const std::array bodies{
        Body{"rows, exact", {.fetch = Fetch::Rows}},
        Body{"samples, exact", {.fetch = Fetch::Samples}},
        Body{"linear, then exact", {.fetch = Fetch::Linear}},
        Body{"linear alone", {.fetch = Fetch::Linear, .is_refined_exactly = false}},
        Body{"linear of 8 bits, then exact", {.fetch = Fetch::Linear, .fraction_bits = 8}},
        Body{"linear of 8 bits alone",
             {.fetch = Fetch::Linear, .fraction_bits = 8, .is_refined_exactly = false}}};
    const std::shared_ptr<const FieldSource> samples = study_distances(1e6);
    const auto control = control_samples(samples, Filter::Interpolating);
    const ReferenceCaster truth(*control, 0);
    const Camera camera = study_camera();
    constexpr int size = study_size;
    std::vector<double> roots(std::size_t{size} * size,
                              std::numeric_limits<double>::quiet_NaN()); // [voxels] from the eye
    const auto ray_of = [&](int x, int y) {
        Ray ray = camera_ray(camera, size, size, x + 0.5, y + 0.5);
        ray.direction_world.normalize();
        return ray;
    };
    tbb::parallel_for(0, size, [&](int y) {
        for (int x = 0; x < size; ++x)
            if (const auto t = truth.hit(ray_of(x, y)))
                roots[static_cast<std::size_t>(y * size + x)] = *t;
    });
    fmt::print("\nFetches, interpolating, exact torus {}^3 @ {}^2, against the double twin: values "
               "at 100000 points, hits along the ray [voxels]; normals [degrees]; pixels with and "
               "without a hit that differ; median ms of the hit and the gradient pass\n"
               "{:<30} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7} {:>8} {:>8}\n",
               study_resolution, size, "", "value RMS", "max", "allowed", "hit RMS", "max",
               "norm. RMS", "max", "differ", "hit", "gradient");
    for (const Body& body : bodies) {
        const ValueErrors values = value_errors(*control, truth, body.storage);
        renderer.load({.field = samples, .storage = body.storage});
        std::vector<double> hit_ms;
        std::vector<double> gradient_ms;
        for (int turn = -1; turn < repeats; ++turn) {
            const FrameReport report =
                renderer.draw(camera, size, size, {FrameImage::Hit, FrameImage::Gradient});
            if (turn < 0) continue;
            hit_ms.push_back(report.passes[0].milliseconds);
            gradient_ms.push_back(report.passes[1].milliseconds);
        }
        const Image hits = renderer.read(FrameImage::Hit);
        const Image gradients = renderer.read(FrameImage::Gradient);
        Error hit_error;
        Error normal_error;
        int differing = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const double root = roots[static_cast<std::size_t>(y * size + x)];
                const float* h = hits.pixel(x, y);
                if (h[3] == 0 || std::isnan(root)) {
                    differing += (h[3] != 0) != !std::isnan(root);
                    continue;
                }
                const Vec3d from_eye(h[0], h[1], h[2]);
                const Ray ray = ray_of(x, y);
                hit_error.add(std::abs(
                    (camera.eye_world + from_eye - ray.origin_world).dot(ray.direction_world) -
                    root));
                const float* g = gradients.pixel(x, y);
                normal_error.add(
                    degrees_between(Vec3d(g[0], g[1], g[2]),
                                    truth.gradient(ray.origin_world + root * ray.direction_world)));
            }
        fmt::print("{:<30} {:>9.2e} {:>9.2e} {:>9.2e} {:>9.2e} {:>9.2e} {:>9.2e} {:>9.2e} {:>7} "
                   "{:>8.2f} {:>8.2f}\n",
                   body.name, values.error.rms(), values.error.max, values.allowed, hit_error.rms(),
                   hit_error.max, normal_error.rms(), normal_error.max, differing,
                   timing_of(hit_ms).median, timing_of(gradient_ms).median);
        std::fflush(stdout);
    }
}

} // namespace isocast
