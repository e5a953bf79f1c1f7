// How the cost of a band grows with triangles, resolution and width (thesis tables 4.2 to 4.5).
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"

#include <fmt/format.h>

#include <chrono>

namespace {

using namespace isocast;

struct Timing {
    double seconds;
    std::int64_t samples;
    double evaluations_per_sample;
};

Timing time_of(const Mesh& mesh, int resolution, double band, BandMethod method) {
    const double voxel = bounding_box(mesh).size().maxCoeff() / resolution;
    // The band's width is a part of the model's extent, half of it on either side.
    const ConvertOptions options{
        .voxel_size_world = voxel, .half_width_voxels = band * resolution / 2, .method = method};
    const auto start = std::chrono::steady_clock::now();
    const ConvertResult result = convert(check(mesh), options);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::int64_t samples = result.field.active_voxel_count();
    return {seconds, samples, double(result.distance_evaluations) / double(samples)};
}

void print_row(const std::string& what, const Mesh& mesh, int resolution, double band) {
    time_of(mesh, 32, 0.2, BandMethod::Scan); // to warm up
    const Timing ours = time_of(mesh, resolution, band, BandMethod::Scan);
    fmt::print("{:<28} {:>10} {:>12} {:>9.3f} {:>8.1f} {:>8.1f}", what, mesh.triangles.size(),
               ours.samples, ours.seconds, ours.seconds / double(ours.samples) * 1e9,
               ours.evaluations_per_sample);
    // The reference is slow: not beyond 30 million samples.
    if (ours.samples < 30'000'000) {
        const Timing csc = time_of(mesh, resolution, band, BandMethod::Csc);
        fmt::print(" {:>9.3f} {:>7.1f}", csc.seconds, csc.seconds / ours.seconds);
    }
    fmt::print("\n");
}

/// files  meshes, beside the built-in ones
void run(const std::vector<std::string>& files) {
    fmt::print("Spheres; exact bands by scan conversion beside CSC (one thread, reference).\n");
    fmt::print("{:<28} {:>10} {:>12} {:>9} {:>8} {:>8} {:>9} {:>7}\n", "", "triangles", "samples",
               "scan s", "ns/samp.", "evals", "CSC s", "ratio");
    for (int levels = 4; levels <= 7; ++levels)
        print_row("mesh size, 256, band 0.1", subdivided_sphere(levels), 256, 0.1);
    const Mesh sphere6 = subdivided_sphere(6);
    for (const double band : {0.1, 0.2, 0.4, 0.8})
        print_row(fmt::format("band {}, 256", band), sphere6, 256, band);
    for (const int resolution : {64, 128, 256, 512, 1024})
        print_row(fmt::format("resolution {}, band 0.1", resolution), sphere6, resolution, 0.1);
    for (const char* name : {"sphere6", "knot", "torus", "seashell"})
        print_row(fmt::format("{}, 256, band 0.1", name), sample_mesh(name), 256, 0.1);
    for (const std::string& file : files)
        print_row(fmt::format("{}, 256, band 0.1", std::filesystem::path(file).stem().string()),
                  read_mesh(file), 256, 0.1);
}

} // namespace

int main(int argc, char** argv) {
    try {
        run({argv + 1, argv + argc});
    } catch (const std::exception& error) {
        fmt::print(stderr, "bench_scaling: {}\n", error.what());
        return 1;
    }
}
