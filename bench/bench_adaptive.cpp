// Adaptive fields beside the thesis's builders, and beside bands and grids that err as much.
// SPDX-License-Identifier: MPL-2.0
#include "bench/adaptive/mesh_in_cells.h"
#include "bench/adaptive/thesis_builders.h"
#include "distance_transform/convert_adaptive.h"
#include "distance_transform/mesh_distance.h"
#include "distance_transform/mesh_files.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <ctime>
#include <filesystem>
#include <random>

namespace isocast {
namespace {

/// Of all threads: what others run on the machine does not count.
double cpu_seconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Counts the distances that are asked for, and the cubes for their surface.
class CountedDistance final : public ExactDistance {
public:
    explicit CountedDistance(const ExactDistance& distance) : distance_(distance) {}
    Sample at(const Vec3d& p, Hint& hint) const override {
        ++points;
        return distance_.at(p, hint);
    }
    SurfaceInCube surface_in(const Cube& cube, const CellFunction& g,
                             double tolerance) const override {
        ++cubes;
        return distance_.surface_in(cube, g, tolerance);
    }
    mutable std::atomic<std::size_t> points = 0;
    mutable std::atomic<std::size_t> cubes = 0;

private:
    const ExactDistance& distance_;
};

std::size_t missed_of(const CellSet& surface, const HashedOctree& tree) {
    std::size_t missed = 0;
    for (int z = 0; z < surface.across(); ++z)
        for (int y = 0; y < surface.across(); ++y)
            for (int x = 0; x < surface.across(); ++x)
                missed += surface.contains({x, y, z}) && !tree.find({{x, y, z}, 0});
    return missed;
}

/// One thread, as the thesis's builders have.
void compare_builders(const std::string& name, const Mesh& placed, int depth, bool with_bottom_up) {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const CheckedMesh mesh = check(placed);
    const MeshDistance distance(mesh.mesh, mesh.topology, nullptr);
    const CellSet surface = surface_cells(mesh.mesh, depth, -1e-9);
    const auto print_row = [&](const std::string& builder, const auto& build) {
        const double start = cpu_seconds();
        const auto [tree, evaluations, cubes] = build();
        const double seconds = cpu_seconds() - start;
        fmt::print("| {} | {} | {} | {} | {} of {} | {} | {} | {:.2f} |\n", name, depth, builder,
                   tree.cell_count(), missed_of(surface, tree), surface.count(), evaluations, cubes,
                   seconds);
        std::fflush(stdout);
    };
    struct Built {
        HashedOctree tree;
        std::size_t evaluations;
        std::size_t cubes;
    };
    for (const int look_ahead : {0, 1, 2, 3})
        print_row(look_ahead == 0 ? "corners" : fmt::format("look-ahead {}", look_ahead), [&] {
            auto [tree, evaluations] = built_top_down(distance, depth, look_ahead);
            return Built{std::move(tree), evaluations, 0};
        });
    if (with_bottom_up)
        print_row("bottom up", [&] {
            auto [tree, evaluations] = built_bottom_up(distance, depth);
            return Built{std::move(tree), evaluations, 0};
        });
    print_row("ours", [&] {
        const CountedDistance counted(distance);
        HashedOctree tree =
            build_adaptive(counted, {.depth = depth, .max_error_cells = std::nullopt});
        return Built{std::move(tree), counted.points, counted.cubes};
    });
}

/// A mesh, and points at which fields of it are measured.
class Measured {
public:
    explicit Measured(const Mesh& mesh)
        : input(check(mesh)), longest(bounding_box(input.mesh).size().maxCoeff()),
          exact_(input.mesh, input.topology, nullptr) {}

    struct Errors {
        double worst = 0;
        double rms = 0;
    };
    /// At 200,000 points within `reach` of random ones of random triangles [world].
    template<class Field>
    Errors errors_of(const Field& field, double reach) const {
        std::mt19937 random(1);
        std::uniform_int_distribution<std::size_t> any_triangle(0, input.mesh.triangles.size() - 1);
        std::uniform_real_distribution<double> any(0, 1);
        std::normal_distribution<double> normal;
        std::vector<Vec3d> points(200'000);
        for (Vec3d& p : points) {
            const auto& [a, b, c] = input.mesh.triangles[any_triangle(random)];
            double u = any(random);
            double v = any(random);
            if (u + v > 1) {
                u = 1 - u;
                v = 1 - v;
            }
            const std::vector<Vec3d>& corners = input.mesh.vertices_world;
            p = corners[a] + u * (corners[b] - corners[a]) + v * (corners[c] - corners[a]);
            const Vec3d direction(normal(random), normal(random), normal(random));
            p += reach * any(random) * direction.normalized();
        }
        std::vector<double> errors(points.size());
        tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
            ExactDistance::Hint hint = 0;
            const double d = reach > 0 ? exact_.at(points[i], hint).distance : 0;
            errors[i] = std::abs(field(points[i]) - d);
        });
        Errors all;
        for (const double error : errors) {
            all.worst = std::max(all.worst, error);
            all.rms += error * error / static_cast<double>(errors.size());
        }
        return {all.worst, std::sqrt(all.rms)};
    }
    Errors errors_of(const AdaptiveConvertResult& result, double reach) const {
        return errors_of(
            [&](const Vec3d& p) { return result.tree.value_at(result.space.to_index(p)); }, reach);
    }

    CheckedMesh input;
    double longest;

private:
    MeshDistance exact_;
};

double trilinear(const SparseField& field, const Vec3d& p_world) {
    const Vec3d p = field.space().to_index(p_world);
    const Index3 lo = p.array().floor().cast<int>().matrix();
    const Vec3d t = p - lo.cast<double>();
    std::array<float, 8> values;
    field.copy_box({lo, (lo.array() + 2).matrix()}, 0, values);
    double sum = 0;
    for (int i = 0; i < 8; ++i)
        sum += values[static_cast<std::size_t>(i)] * (i & 1 ? t.x() : 1 - t.x()) *
               (i & 2 ? t.y() : 1 - t.y()) * (i & 4 ? t.z() : 1 - t.z());
    return sum;
}

struct Band {
    int resolution; // along the longest side
    std::int64_t active_voxels;
    double dense_samples; // of a grid of the box and the band around it
    double seconds;
};

/// The coarsest band three voxels wide to each side that errs by no more, to 2 % of its
/// resolution.
Band band_that_errs_by(const Measured& mesh, double worst, double reach) {
    constexpr double half_width = 3;
    const auto band_at = [&](int resolution) {
        const double start = cpu_seconds();
        ConvertResult result = convert(
            mesh.input, {.voxel_size_world = mesh.longest / resolution, .half_width_voxels = 3});
        const double seconds = cpu_seconds() - start;
        const Vec3d voxels = bounding_box(mesh.input.mesh).size() / mesh.longest * resolution;
        const Band band{resolution, result.field.active_voxel_count(),
                        (voxels.array() + 2 * half_width + 1).prod(), seconds};
        const double error =
            mesh.errors_of([&](const Vec3d& p) { return trilinear(result.field, p); }, reach).worst;
        return std::pair(band, error);
    };
    int too_coarse = 32;
    auto [band, error] = band_at(2 * too_coarse);
    for (; error > worst; std::tie(band, error) = band_at(2 * too_coarse)) too_coarse *= 2;
    while (band.resolution - too_coarse > band.resolution / 50) {
        const auto [middle, its_error] = band_at((too_coarse + band.resolution) / 2);
        if (its_error <= worst)
            band = middle;
        else
            too_coarse = middle.resolution;
    }
    return band;
}

/// Least seconds of the processors' time, of all threads, of some runs.
AdaptiveConvertResult timed(const CheckedMesh& mesh, const AdaptiveConvertOptions& options,
                            int runs, double& seconds) {
    seconds = std::numeric_limits<double>::infinity();
    for (int i = 0;; ++i) {
        const double start = cpu_seconds();
        AdaptiveConvertResult result = convert_adaptive(mesh, options);
        seconds = std::min(seconds, cpu_seconds() - start);
        if (i + 1 == runs) return result;
    }
}

std::size_t free_nodes_of(const HashedOctree& tree) {
    std::size_t count = 0;
    for (HashedOctree::NodeNumber node = 0; node < tree.node_count(); ++node)
        count += !tree.is_constrained(node);
    return count;
}

void print_tree(const std::string& name, const Measured& mesh,
                const AdaptiveConvertOptions& options, int runs) {
    double seconds = 0;
    const AdaptiveConvertResult result = timed(mesh.input, options, runs, seconds);
    const double max_error = *options.max_error_world;
    const double reach = options.accurate_within_world;
    const auto errors = mesh.errors_of(result, reach);
    fmt::print("| {} | {} | {:.0e} | {} | {} | {} | {} | {} | {:.2f} | {:.2f} | {:.3f} |", name,
               options.filter == OctreeFilter::Linear ? "linear" : "cubic",
               max_error / mesh.longest, reach > 0 ? "3 E" : "0", free_nodes_of(result.tree),
               result.tree.node_count(), result.tree.cell_count(), result.tree.memory_bytes(),
               seconds, errors.worst / max_error, errors.rms / max_error);
    std::fflush(stdout);
}

void compare_with_band(const std::string& name, const Measured& mesh) {
    const double max_error = 1e-3 * mesh.longest;
    for (const OctreeFilter filter : {OctreeFilter::Linear, OctreeFilter::Cubic})
        for (const double reach : {0.0, 3 * max_error}) {
            const AdaptiveConvertOptions options{
                .max_error_world = max_error, .accurate_within_world = reach, .filter = filter};
            print_tree(name, mesh, options, 3);
            const AdaptiveConvertResult result = convert_adaptive(mesh.input, options);
            const auto nodes = static_cast<double>(free_nodes_of(result.tree));
            const Band band = band_that_errs_by(mesh, mesh.errors_of(result, reach).worst, reach);
            fmt::print(" {} | {} | {:.3g} | {:.2f} | {:.1f} | {:.0f} |\n", band.resolution,
                       band.active_voxels, band.dense_samples, band.seconds,
                       static_cast<double>(band.active_voxels) / nodes, band.dense_samples / nodes);
        }
}

void run(const std::filesystem::path& folder, const std::string& only, int from, int to,
         int bottom_up_to, double least_error) {
    const std::array meshes = {"bunny-closed", "armadillo"};
    const auto mesh_of = [&](const std::string& name) {
        return read_mesh(folder / (name + ".obj"));
    };
    if (only.empty() || only == "builders") {
        fmt::print("| field | depth | builder | cells | missed | distances | cubes | s |\n");
        for (int depth = from; depth <= to; ++depth) {
            for (const char* name : meshes)
                compare_builders(name, mesh_in_cells(mesh_of(name), depth), depth,
                                 depth <= bottom_up_to);
            Mesh needles;
            for (const Mesh& needle : needles_in_cells(depth, 0.3, 1)) add_mesh(needle, needles);
            compare_builders("needles", needles, depth, depth <= bottom_up_to);
        }
    }
    const std::string head = "| mesh | filter | E | within | free nodes | nodes | cells | bytes | "
                             "s | worst/E | rms/E |";
    if (only.empty() || only == "band") {
        fmt::print("{} resolution | voxels | dense | s | voxels/nodes | dense/nodes |\n", head);
        for (const char* name : meshes) compare_with_band(name, Measured(mesh_of(name)));
    }
    if (only.empty() || only == "sweep") {
        fmt::print("{}\n", head);
        for (const char* name : meshes) {
            const Measured mesh(mesh_of(name));
            for (const OctreeFilter filter : {OctreeFilter::Linear, OctreeFilter::Cubic})
                for (const double error : {1e-2, 3e-3, 1e-3, 3e-4, 1e-4}) {
                    if (error < least_error) break;
                    print_tree(name, mesh,
                               {.max_error_world = error * mesh.longest, .filter = filter}, 1);
                    fmt::print("\n");
                }
        }
    }
}

} // namespace
} // namespace isocast

int main(int argc, char** argv) {
    std::filesystem::path folder = ISOCAST_SHARED_DATA;
    std::string only;
    int from = 7;
    int to = 9;
    int bottom_up_to = 8;
    double least_error = 1e-4;
    CLI::App app{"Adaptive distance fields: what builders miss, and what fields take and err by"};
    app.add_option("--data", folder, "folder of bunny-closed.obj and armadillo.obj");
    app.add_option("--only", only, "of the tables")
        ->check(CLI::IsMember({"builders", "band", "sweep"}));
    app.add_option("--from", from, "least depth at which builders are compared");
    app.add_option("--to", to, "greatest depth at which builders are compared");
    app.add_option("--bottom-up-to", bottom_up_to, "greatest depth of the bottom-up builder");
    app.add_option("--least-error", least_error, "of the sweep, in longest sides");
    CLI11_PARSE(app, argc, argv);
    try {
        isocast::run(folder, only, from, to, bottom_up_to, least_error);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "bench_adaptive: %s\n", error.what());
        return 1;
    }
}
