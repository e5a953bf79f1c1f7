// Points to band: time, and errors against the meshes whose vertices the points are.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert_points.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>

namespace {

using namespace isocast;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// All samples of `box`, x fastest.
std::vector<float> samples_of(const SparseField& field, const IndexBox& box) {
    std::vector<float> values(static_cast<std::size_t>(box.sample_count()));
    field.copy_box(box, 0, values);
    return values;
}

struct Errors {
    double rms_sampled = 0; // of samples within a spacing of a point, along the mesh [voxels]
    double sampled = 0;     // their share of the band
    double rms = 0;         // of all samples that truly are in the band
    double worst = 0;
    std::int64_t crossings = 0;
    /// Farther from the mesh than a voxel and the spacing there, and than a voxel and the way along
    /// the mesh to the nearest point (over a gap a slope of 45 degrees is no fault).
    std::int64_t spurious = 0;
    std::int64_t off = 0;         // the same with half a spacing
    double farthest_crossing = 0; // from the mesh [voxels]
};

/// A crossing is a pair of neighbouring samples of different sign, in or out of the band; its
/// distance from the mesh is that of the nearer of the two, by the exact transform.
Errors errors_of(const SparseField& field, const CheckedMesh& mesh, const CheckedPoints& points,
                 const ConvertOptions& options) {
    const double voxel = options.voxel_size_world;
    ConvertOptions exact_options = options;
    exact_options.half_width_voxels = 20;
    const SparseField exact = convert(mesh, exact_options).field;
    const IndexBox box = exact.extent();
    const std::vector<float> ours = samples_of(field, box);
    const std::vector<float> truth = samples_of(exact, box);
    const PointTree tree(points.cloud.points_world);
    std::vector<Neighbour> seen;
    Errors errors;
    double count = 0;
    double sampled_count = 0;
    const Index3 size = box.size();
    const std::array<std::int64_t, 3> stride = {1, size.x(), std::int64_t{size.x()} * size.y()};
    for (std::int64_t i = 0; i < box.sample_count(); ++i) {
        const double d = truth[i] / voxel;
        if (std::abs(d) >= exact_options.half_width_voxels && std::abs(ours[i]) >= 3 * voxel)
            continue;
        const Index3 at(static_cast<int>(i % stride[1]), static_cast<int>(i / stride[1] % size.y()),
                        static_cast<int>(i / stride[2]));
        tree.nearest(exact.space().to_world((box.lo + at).cast<double>()), 1, seen);
        const double spacing = points.spacing_world[seen[0].point] / voxel;
        const double gap =
            std::sqrt(std::max(seen[0].squared_distance / (voxel * voxel) - d * d, 0.0));
        if (std::abs(d) <= options.half_width_voxels) {
            const double square = std::pow(ours[i] / voxel - d, 2);
            errors.rms += square;
            ++count;
            if (gap <= spacing) errors.rms_sampled += square;
            if (gap <= spacing) ++sampled_count;
            errors.worst = std::max(errors.worst, std::sqrt(square));
        }
        for (int axis = 0; axis < 3; ++axis) {
            if (at[axis] + 1 == size[axis]) continue;
            const std::int64_t next = i + stride[axis];
            if ((ours[i] < 0) == (ours[next] < 0)) continue;
            ++errors.crossings;
            if ((truth[i] < 0) != (truth[next] < 0)) continue; // the mesh passes between them
            const double away = std::min(std::abs(d), std::abs(truth[next] / voxel));
            errors.farthest_crossing = std::max(errors.farthest_crossing, away);
            if (away > 1 + std::max(spacing, gap)) ++errors.spurious;
            if (away > 1 + std::max(spacing / 2, gap)) ++errors.off;
        }
    }
    errors.rms = std::sqrt(errors.rms / count);
    errors.rms_sampled = std::sqrt(errors.rms_sampled / sampled_count);
    errors.sampled = sampled_count / count;
    return errors;
}

void run(const std::string& name, const MeshlessOptions& meshless, int resolution,
         bool without_normals, bool is_timed_only) {
    const CheckedMesh mesh =
        check(std::filesystem::exists(name) ? read_mesh(name) : sample_mesh(name));
    PointCloud cloud = vertices_of(mesh);
    if (without_normals) cloud.normals.clear();
    const ConvertOptions options{
        .voxel_size_world = voxel_size_for_resolution(bounding_box(mesh.mesh), resolution)};
    const auto start = Clock::now();
    const std::clock_t cpu_start = std::clock();
    const CheckedPoints points = check(cloud, meshless.neighbours);
    const ConvertResult result = convert_points(points, options, meshless);
    const double seconds = seconds_since(start);
    const double cpu_seconds = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
    fmt::print("{:<18} {:<16} {:>4} {:>6} {:>6.2f} {:>9} {:>7.2f} {:>7.2f} {:>9.2f} {:>6.2f}",
               std::filesystem::path(name).filename().string(), name_of(meshless.method),
               resolution, points.cloud.points_world.size(),
               points.median_spacing_world / options.voxel_size_world,
               result.field.active_voxel_count(), result.time.prepare_seconds,
               result.time.transform_seconds, seconds, cpu_seconds);
    if (is_timed_only) {
        fmt::print("\n");
        return;
    }
    const Errors errors = errors_of(result.field, mesh, points, options);
    fmt::print(" {:>8.4f} {:>7.2f} {:>8.4f} {:>7.3f} {:>9} {:>8} {:>6} {:>8.2f}\n",
               errors.rms_sampled, 100 * errors.sampled, errors.rms, errors.worst, errors.crossings,
               errors.spurious, errors.off, errors.farthest_crossing);
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Points to field: time and errors");
    std::vector<std::string> names;
    std::vector<std::string> methods = {"partition"};
    int resolution = 128;
    int threads = 2;
    MeshlessOptions options;
    bool without_normals = false;
    bool is_timed_only = false;
    app.add_option("MESH", names, "Mesh files or names of built-in meshes")->required();
    app.add_option("--methods", methods);
    app.add_option("--resolution", resolution);
    app.add_option("--threads", threads);
    app.add_option("--neighbours", options.neighbours);
    app.add_option("--approximation", options.approximation);
    app.add_flag("--without-normals", without_normals, "Let them be estimated");
    app.add_flag("--time-only", is_timed_only);
    CLI11_PARSE(app, argc, argv);
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
    fmt::print(
        "Lengths in voxels. RMS errors: of samples within a spacing of a point along the "
        "mesh, their share in per cent, of the whole band.\n"
        "{:<18} {:<16} {:>4} {:>6} {:>6} {:>9} {:>7} {:>7} {:>9} {:>6} {:>8} {:>7} {:>8} {:>7} "
        "{:>9} {:>8} {:>6} {:>8}\n",
        "cloud", "method", "N", "points", "apart", "active", "prepare", "band", "seconds", "CPU",
        "sampled", "share", "band", "worst", "crossings", "spurious", "off", "farthest");
    for (const std::string& name : names) {
        for (const std::string& method : methods) {
            options.method = point_method_from_name(method);
            try {
                run(name, options, resolution, without_normals, is_timed_only);
            } catch (const std::exception& error) {
                fmt::print("{:<18} {:<16} {}\n", std::filesystem::path(name).filename().string(),
                           method, error.what());
            }
        }
    }
}
