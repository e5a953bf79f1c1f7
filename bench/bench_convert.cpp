// Mesh to band: isocast beside OpenVDB, in one run on one grid.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"
#include "distance_transform/kd_dense.h"
#include "distance_transform/mesh_files.h"
#include "median.h"
#include "volume/vdb_grid.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>

namespace {

using namespace isocast;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

struct VdbInput {
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
};

VdbInput vdb_input(const Mesh& mesh) {
    VdbInput input;
    for (const Vec3d& p : mesh.vertices_world)
        input.points.emplace_back(float(p.x()), float(p.y()), float(p.z()));
    for (const auto& [a, b, c] : mesh.triangles) input.triangles.emplace_back(a, b, c);
    return input;
}

struct Case {
    std::string name;
    int resolution;
    double half_width_voxels;
};

/// The voxel size of the published comparisons: longest side / (N - 9).
double voxel_size(const Mesh& mesh, int resolution) {
    return bounding_box(mesh).size().maxCoeff() / (resolution - 9);
}

tbb::global_control threads(int count) {
    return {tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count)};
}

struct Run {
    double seconds; // the mesh's verdict included
    double check_seconds;
    ConvertResult result;
};

Run run_ours(const Mesh& mesh, const ConvertOptions& options, int thread_count) {
    const auto control = threads(thread_count);
    const auto start = Clock::now();
    const CheckedMesh checked = check(mesh);
    const double check_seconds = seconds_since(start);
    ConvertResult result = convert(checked, options);
    return {seconds_since(start), check_seconds, std::move(result)};
}

double run_openvdb(const VdbInput& input, const ConvertOptions& options) {
    const auto control = threads(2);
    const auto transform =
        openvdb::math::Transform::createLinearTransform(options.voxel_size_world);
    const auto start = Clock::now();
    const auto grid = openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(
        *transform, input.points, input.triangles, float(options.half_width_voxels));
    return seconds_since(start);
}

/// The three in turn, each once to warm up and once timed, so that a machine's drift is in all of
/// them; ratios are of each turn.
void run_case(const Mesh& mesh, const Case& c, int repeats, bool with_openvdb) {
    const ConvertOptions options{.voxel_size_world = voxel_size(mesh, c.resolution),
                                 .half_width_voxels = c.half_width_voxels > 0
                                                          ? c.half_width_voxels
                                                          : 0.1 * (c.resolution - 9)};
    const VdbInput input = vdb_input(mesh);
    std::map<std::string, std::vector<double>> taken;
    std::int64_t active = 0;
    std::int64_t evaluations = 0;
    for (int i = 0; i < repeats; ++i) {
        run_ours(mesh, options, 2);
        {
            const Run two = run_ours(mesh, options, 2);
            taken["two"].push_back(two.seconds);
            taken["check"].push_back(two.check_seconds);
            taken["prepare"].push_back(two.result.time.prepare_seconds);
            taken["transform"].push_back(two.result.time.transform_seconds);
            active = two.result.field.active_voxel_count();
            evaluations = two.result.distance_evaluations;
        }
        if (with_openvdb) {
            run_openvdb(input, options);
            taken["OpenVDB"].push_back(run_openvdb(input, options));
        } else {
            taken["OpenVDB"].push_back(NAN);
        }
        run_ours(mesh, options, 1);
        taken["one"].push_back(run_ours(mesh, options, 1).seconds);
        taken["ratio"].push_back(taken["OpenVDB"].back() / taken["two"].back());
        taken["speed-up"].push_back(taken["one"].back() / taken["two"].back());
    }
    const auto of = [&](const std::string& what) { return median(taken[what]); };
    fmt::print(
        "{:<8} {:>6.1f} {:>9} {:>8.4f} {:>8.4f} {:>7.1f} {:>8.4f} {:>8.2f} {:>8.4f} {:>8.4f} "
        "{:>9.4f} {:>7.2f}\n",
        c.name, options.half_width_voxels, active, of("two"), of("OpenVDB"), of("ratio"), of("one"),
        of("speed-up"), of("check"), of("prepare"), of("transform"),
        double(evaluations) / double(active));
}

/// Every sample of resolution^3 about the mesh, exact.
void run_dense(const Mesh& mesh, int resolution) {
    const ConvertOptions options{.voxel_size_world = voxel_size(mesh, resolution)};
    const CheckedMesh checked = check(mesh);
    const LatticeMesh lattice = on_lattice(checked.mesh, options.voxel_size_world, 3);
    const Index3 lo = lattice.anchor - Index3::Constant(resolution / 2);
    const auto start = Clock::now();
    const KdDenseResult dense = dense_distances(lattice, checked.topology, KdTree(lattice.mesh),
                                                {.box = {lo, lo + Index3::Constant(resolution)}});
    const double seconds = seconds_since(start);
    const double samples = double(dense.field.extent().sample_count());
    fmt::print("full dense {}^3: {:.2f} s, {:.0f} ns a sample, {:.1f} distances a sample\n",
               resolution, seconds, seconds / samples * 1e9,
               double(dense.distance_evaluations) / samples);
}

/// The greatest resident memory since it was last reset, where the system tells it.
double peak_bytes() {
    std::ifstream file("/proc/self/status");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) * 1024;
    return NAN;
}

void run_memory(const Mesh& mesh, int resolution) {
    std::ofstream("/proc/self/clear_refs") << 5; // resets the peak
    const ConvertResult result =
        convert(check(mesh), {.voxel_size_world = voxel_size(mesh, resolution)});
    const double peak = peak_bytes();
    const auto grid_bytes = double(to_vdb_grid(result.field)->memUsage());
    fmt::print("{}^3, half width 3: peak {:.0f} MB, with the OpenVDB grid beside it {:.0f} MB, the "
               "grid's memUsage() {:.0f} MB: {:.2f} and {:.2f} times\n",
               resolution, peak / 1e6, peak_bytes() / 1e6, grid_bytes / 1e6, peak / grid_bytes,
               peak_bytes() / grid_bytes);
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Mesh to field: isocast beside OpenVDB");
    std::string path;
    int repeats = 5;
    bool no_openvdb = false;
    std::string only;
    app.add_option("MESH", path, "Mesh file")->required();
    app.add_option("--repeats", repeats);
    app.add_flag("--no-openvdb", no_openvdb);
    app.add_option("--only", only, "A case by its name, e.g. 256/3, dense or memory");
    CLI11_PARSE(app, argc, argv);
    openvdb::initialize();
    const Mesh mesh = read_mesh(path);
    fmt::print("Medians of seconds: ours on two threads, OpenVDB on two, ours on one; of the first "
               "the parts.\n{:<8} {:>6} {:>9} {:>8} {:>8} {:>7} {:>8} {:>8} {:>8} {:>8} {:>9} "
               "{:>7}\n",
               "case", "half", "active", "ours", "OpenVDB", "ratio", "one", "speed-up", "check",
               "prepare", "transform", "evals");
    for (const Case& c : {Case{"256/3", 256, 3}, Case{"512/3", 512, 3}, Case{"256/21", 256, 21},
                          Case{"256/10%", 256, 0}})
        if (only.empty() || only == c.name) run_case(mesh, c, repeats, !no_openvdb);
    if (only.empty() || only == "dense") run_dense(mesh, 256);
    if (only.empty() || only == "memory") run_memory(mesh, 2048);
}
