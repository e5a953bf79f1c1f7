// Scan conversion on the GPU beside the CPU's, over the thesis's tables 4.2 to 4.5.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/checked_mesh.h"
#include "distance_transform/convert.h"
#include "distance_transform/gl/scan_on_gpu.h"
#include "distance_transform/lattice.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "distance_transform/tile_transform.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <limits>

namespace {

using namespace isocast;

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class Bench {
public:
    Bench(gl::Context& context, gl::ShaderLibrary& shaders) : context_(context), shaders_(shaders) {
        for (const gl::ProgramKey& key : scan_programs()) shaders.program(key); // not to be timed
    }

    static void print_header(const char* title) {
        fmt::print("\n{}\n{:10} {:>9} {:>5} {:>6} {:>10} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} "
                   "{:>9} {:>9} {:>8}\n",
                   title, "mesh", "triangles", "N", "band", "samples", "shared", "CPU", "GL",
                   "setup", "draw", "wait", "exact", "candid.", "sections", "CPU/GL");
    }

    /// band  half width as a part of the longest side
    void row(const std::string& name, const Mesh& mesh, int resolution, double band) {
        const CheckedMesh checked = check(mesh);
        const auto start = std::chrono::steady_clock::now();
        // Nine voxels of border, as in the figures that the project compares with.
        const double voxel = voxel_size_for_resolution(bounding_box(checked.mesh), resolution - 9);
        const double half_width = std::max(1.0, band * (resolution - 9));
        const LatticeMesh lattice = on_lattice(checked.mesh, voxel, half_width);
        const Sites sites(lattice.mesh, checked.topology, half_width);
        const BandTiles found = find_band_tiles(sites, std::numeric_limits<double>::infinity(), {});
        const double shared = seconds_since(start);

        const auto cpu_start = std::chrono::steady_clock::now();
        std::int64_t samples = 0;
        {
            TileTransform transform(sites, {}, voxel, found.block_count);
            tbb::parallel_for(std::size_t{0}, found.tiles.size(), [&](std::size_t i) {
                transform.run(found.tiles[i], found.sites_of(found.tiles[i]));
            });
            for (const FieldBlock& block : transform.take().blocks)
                samples += static_cast<std::int64_t>(block.active.count());
        }
        const double cpu = seconds_since(cpu_start);

        const auto gl_start = std::chrono::steady_clock::now();
        const GpuScan scan = scan_on_gpu(context_, shaders_, sites, found, nullptr, voxel);
        const double gl = seconds_since(gl_start);
        const auto per_sample = [&](std::int64_t n) {
            return static_cast<double>(n) / static_cast<double>(samples);
        };
        fmt::print(
            "{:10} {:9} {:5} {:6.2f} {:10} {:8.3f} {:8.3f} {:8.3f} {:8.3f} {:8.3f} {:8.3f} {:8.3f} "
            "{:9.3f} {:9.3f} {:8.3f}\n",
            name, checked.mesh.triangles.size(), resolution, band, samples, shared, cpu, gl,
            scan.time.sections_seconds, scan.time.draw_seconds, scan.time.wait_seconds,
            scan.time.exact_seconds, per_sample(scan.candidates), per_sample(scan.sections),
            cpu / gl);
        std::fflush(stdout);
    }

private:
    gl::Context& context_;
    gl::ShaderLibrary& shaders_;
};

} // namespace

int main(int argc, char** argv) {
    std::string bunny;
    std::string backend = "auto";
    std::string shader_folder = "shaders";
    int resolution = 128;
    CLI::App app("Scan conversion on the GPU beside the CPU's");
    app.add_option("--bunny", bunny, "Mesh file for table 4.2");
    app.add_option("--backend", backend);
    app.add_option("--shaders", shader_folder, "Folder of shaders");
    app.add_option("--resolution", resolution,
                   "Of tables 4.2 to 4.4, and the greatest of table 4.5");
    CLI11_PARSE(app, argc, argv);
    try {
        const auto context = gl::make_context({.backend = gl::backend_from_name(backend)});
        gl::ShaderLibrary shaders({shader_folder});
        const gl::DriverInfo& driver = context->driver();
        fmt::print("{}, {}, {}\n", driver.backend, driver.renderer, driver.version);
        if (driver.renderer.find("llvmpipe") != std::string::npos)
            fmt::print(
                "This is a software rasteriser on the same cores: its times say little about "
                "a GPU's, only how work is divided.\n");
        fmt::print(
            "Seconds. N: longest side in voxels, plus 9. band: half width, as a part of the "
            "longest side. shared: sites and tiles, before either. CPU, GL: from there to "
            "blocks complete. Of GL: draw by the GL's own clock, beside the CPU's setup, wait "
            "and exact distances. candidates and sections for each sample of the band.\n");
        Bench bench(*context, shaders);
        Bench::print_header("Table 4.2: models");
        bench.row("sphere6", subdivided_sphere(6), resolution, 0.1);
        if (!bunny.empty()) bench.row("bunny", read_mesh(bunny), resolution, 0.1);
        bench.row("knot", sample_mesh("knot"), resolution, 0.1);
        Bench::print_header("Table 4.3: size of the mesh");
        for (const int levels : {4, 5, 6, 7})
            bench.row("sphere" + std::to_string(levels), subdivided_sphere(levels), resolution,
                      0.1);
        Bench::print_header("Table 4.4: width of the band");
        for (const double band : {0.1, 0.2, 0.4, 0.8})
            bench.row("sphere6", subdivided_sphere(6), resolution, band);
        Bench::print_header("Table 4.5: resolution");
        for (int n = 64; n <= resolution; n *= 2)
            bench.row("sphere6", subdivided_sphere(6), n, 0.1);
    } catch (const std::exception& error) {
        fmt::print(stderr, "bench_gl: {}\n", error.what());
        return 1;
    }
}
