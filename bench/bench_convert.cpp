// Mesh to band: isocast beside OpenVDB, in one run on one grid.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <optional>

namespace {

using namespace isocast;

double median(std::vector<double> values) {
    std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
    return values[values.size() / 2];
}

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
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

void run_case(const Mesh& mesh, const Case& c, int repeats, bool with_openvdb) {
    // The voxel size of the published comparisons: longest side / (N - 9).
    const double voxel = bounding_box(mesh).size().maxCoeff() / (c.resolution - 9);
    const double half_width =
        c.half_width_voxels > 0 ? c.half_width_voxels : 0.1 * (c.resolution - 9);
    const ConvertOptions options{.voxel_size_world = voxel, .half_width_voxels = half_width};
    // One run to warm up, then the median; what a run gives back is freed outside the time taken.
    std::optional<ConvertResult> result;
    std::vector<double> total;
    std::vector<double> cpu;
    std::vector<double> checking;
    for (int i = -1; i < repeats; ++i) {
        result.reset();
        const std::clock_t cpu_start = std::clock();
        const auto start = std::chrono::steady_clock::now();
        const CheckedMesh checked = check(mesh);
        const double check_seconds = seconds_since(start);
        result.emplace(convert(checked, options));
        if (i < 0) continue;
        total.push_back(seconds_since(start));
        cpu.push_back(double(std::clock() - cpu_start) / CLOCKS_PER_SEC);
        checking.push_back(check_seconds);
    }
    const double ours = median(total);
    const double active = double(result->field.active_voxel_count());
    fmt::print(
        "{:<12} {:>5} {:>6.1f} {:>10.0f} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>7.2f}",
        c.name, c.resolution, half_width, active, ours, median(cpu), median(checking),
        result->time.prepare_seconds, result->time.transform_seconds,
        double(result->distance_evaluations) / active);
    if (with_openvdb) {
        const VdbInput input = vdb_input(mesh);
        const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
        std::vector<double> taken;
        for (int i = -1; i < repeats; ++i) {
            const auto start = std::chrono::steady_clock::now();
            const auto grid = openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(
                *transform, input.points, input.triangles, float(half_width));
            if (i >= 0) taken.push_back(seconds_since(start));
        }
        const double theirs = median(taken);
        fmt::print(" {:>8.4f} {:>7.1f}", theirs, theirs / ours);
    }
    fmt::print("\n");
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Mesh to band: isocast beside OpenVDB");
    std::string path;
    int threads = 2;
    int repeats = 3;
    bool no_openvdb = false;
    int only = 0;
    app.add_option("MESH", path, "Mesh file")->required();
    app.add_option("--threads", threads);
    app.add_option("--repeats", repeats);
    app.add_flag("--no-openvdb", no_openvdb);
    app.add_option("--only", only, "Resolution");
    CLI11_PARSE(app, argc, argv);
    openvdb::initialize();
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const Mesh mesh = read_mesh(path);
    fmt::print("{:<12} {:>5} {:>6} {:>10} {:>8} {:>8} {:>8} {:>8} {:>8} {:>7} {:>8} {:>7}\n",
               "case", "N", "half", "active", "total s", "cpu s", "check", "prepare", "transf",
               "evals", "OpenVDB", "ratio");
    for (const Case& c : {Case{"256/3", 256, 3}, Case{"512/3", 512, 3}, Case{"256/21", 256, 21},
                          Case{"256/10%", 256, 0}})
        if (only == 0 || only == c.resolution + int(c.half_width_voxels))
            run_case(mesh, c, repeats, !no_openvdb);
}
