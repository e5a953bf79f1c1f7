// Mesh to band: isocast beside OpenVDB, in one run on one grid.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"
#include "distance_transform/kd_dense.h"
#include "distance_transform/mesh_files.h"
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
#include <optional>

namespace {

using namespace isocast;

double median(std::vector<double> values) {
    std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
    return values[values.size() / 2];
}

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

struct Timing {
    double total = 0; // medians of seconds, the mesh's verdict included
    double check = 0;
    std::optional<ConvertResult> last;
};

/// One run to warm up, then the median; what a run gives back is freed outside the time taken.
Timing time_ours(const Mesh& mesh, const ConvertOptions& options, int threads, int repeats) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
    Timing timing;
    std::vector<double> total;
    std::vector<double> checking;
    for (int i = -1; i < repeats; ++i) {
        timing.last.reset();
        const auto start = Clock::now();
        const CheckedMesh checked = check(mesh);
        const double check_seconds = seconds_since(start);
        timing.last.emplace(convert(checked, options));
        if (i < 0) continue;
        total.push_back(seconds_since(start));
        checking.push_back(check_seconds);
    }
    timing.total = median(total);
    timing.check = median(checking);
    return timing;
}

double time_openvdb(const Mesh& mesh, const ConvertOptions& options, int threads, int repeats) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
    const VdbInput input = vdb_input(mesh);
    const auto transform =
        openvdb::math::Transform::createLinearTransform(options.voxel_size_world);
    std::vector<double> taken;
    for (int i = -1; i < repeats; ++i) {
        const auto start = Clock::now();
        const auto grid = openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(
            *transform, input.points, input.triangles, float(options.half_width_voxels));
        if (i >= 0) taken.push_back(seconds_since(start));
    }
    return median(taken);
}

void run_case(const Mesh& mesh, const Case& c, int repeats, bool with_openvdb) {
    const ConvertOptions options{.voxel_size_world = voxel_size(mesh, c.resolution),
                                 .half_width_voxels = c.half_width_voxels > 0
                                                          ? c.half_width_voxels
                                                          : 0.1 * (c.resolution - 9)};
    const Timing ours = time_ours(mesh, options, 2, repeats);
    const double theirs = with_openvdb ? time_openvdb(mesh, options, 2, repeats) : NAN;
    const Timing on_one = time_ours(mesh, options, 1, repeats);
    const double active = double(ours.last->field.active_voxel_count());
    fmt::print("{:<8} {:>6.1f} {:>9.0f} {:>8.4f} {:>8.4f} {:>7.1f} {:>8.4f} {:>5.2f} {:>8.4f} "
               "{:>8.4f} {:>8.4f} {:>7.2f}\n",
               c.name, options.half_width_voxels, active, ours.total, theirs, theirs / ours.total,
               on_one.total, on_one.total / ours.total, ours.check, ours.last->time.prepare_seconds,
               ours.last->time.transform_seconds, double(ours.last->distance_evaluations) / active);
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
    fmt::print("Seconds on two threads, and on one; check, prepare and transform are parts of the "
               "first.\n{:<8} {:>6} {:>9} {:>8} {:>8} {:>7} {:>8} {:>5} {:>8} {:>8} {:>8} {:>7}\n",
               "case", "half", "active", "ours", "OpenVDB", "ratio", "one", "1:2", "check",
               "prepare", "transf", "evals");
    for (const Case& c : {Case{"256/3", 256, 3}, Case{"512/3", 512, 3}, Case{"256/21", 256, 21},
                          Case{"256/10%", 256, 0}})
        if (only.empty() || only == c.name) run_case(mesh, c, repeats, !no_openvdb);
    if (only.empty() || only == "dense") run_dense(mesh, 256);
    if (only.empty() || only == "memory") run_memory(mesh, 2048);
}
