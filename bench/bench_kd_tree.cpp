// The thesis's claim about kD-trees with overlapping nodes, measured: bench_kd_tree [MESH…].
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"
#include "distance_transform/kd_dense.h"
#include "distance_transform/kd_tree.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"

#include <fmt/format.h>

#include <chrono>
#include <random>

namespace isocast {
namespace {

struct Variant {
    const char* name;
    KdVariant variant;
};
constexpr std::array variants = {Variant{"overlapping nodes", KdVariant::Overlapping},
                                 Variant{"objects at nodes", KdVariant::ObjectsAtNodes},
                                 Variant{"split references", KdVariant::SplitReferences}};

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Points of a seeded sequence that lie in the box grown by a tenth; in the band of 3 voxels of
/// 1/256 of the longest side, if asked for.
std::vector<Vec3d> query_points(const KdTree& tree, const WorldBox& box, std::size_t count,
                                bool in_band) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    const Vec3d lo = box.min - 0.1 * box.size();
    const Vec3d size = 1.2 * box.size();
    const double band = 3 * voxel_size_for_resolution(box, 256);
    std::vector<Vec3d> points;
    while (points.size() < count) {
        const Vec3d p = lo + Vec3d(unit(random), unit(random), unit(random)).cwiseProduct(size);
        if (!in_band || tree.closest(p, band)) points.push_back(p);
    }
    return points;
}

/// A row of the table: the mean of query(i, statistics) over i < count, timed without counting.
template<class Query>
void print_row(const std::string& mesh, const char* kind, const char* variant, double build_seconds,
               std::size_t count, const Query& query) {
    KdStatistics statistics;
    for (std::size_t i = 0; i < count; ++i) query(i, &statistics);
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < count; ++i) query(i, nullptr);
    const double n = static_cast<double>(count);
    fmt::print("| {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.0f} |\n", mesh, kind, variant,
               build_seconds * 1e3, static_cast<double>(statistics.nodes_visited) / n,
               static_cast<double>(statistics.objects_tested) / n, seconds_since(start) / n * 1e9);
}

void print_queries(const std::string& name, const Mesh& mesh) {
    constexpr std::size_t count = 20000;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const WorldBox box = bounding_box(mesh);
    const KdTree reference(mesh);
    const std::vector<Vec3d> band = query_points(reference, box, count, true);
    const std::vector<Vec3d> anywhere = query_points(reference, box, count, false);
    for (const Variant& variant : variants) {
        const auto start = std::chrono::steady_clock::now();
        const KdTree tree(mesh, variant.variant);
        const double build_seconds = seconds_since(start);
        const auto row = [&](const char* kind, const auto& query) {
            print_row(name, kind, variant.name, build_seconds, count, query);
        };
        row("closest, in the band",
            [&](std::size_t i, KdStatistics* s) { tree.closest(band[i], infinity, s); });
        row("closest, in the box",
            [&](std::size_t i, KdStatistics* s) { tree.closest(anywhere[i], infinity, s); });
        row("8 nearest, in the box",
            [&](std::size_t i, KdStatistics* s) { tree.k_nearest(anywhere[i], 8, s); });
        row("rays towards the band", [&](std::size_t i, KdStatistics* s) {
            tree.first_hit(anywhere[i], band[i] - anywhere[i], infinity, s);
        });
    }
}

/// The dense field of resolution^3 samples about the mesh's middle, by blocks, and rows of it by a
/// query a sample that starts from the last one's answer, on one thread.
void print_dense(const std::string& name, const Mesh& mesh, int resolution) {
    const double voxel = bounding_box(mesh).size().maxCoeff() / (resolution - 9);
    const LatticeMesh lattice = on_lattice(mesh, voxel, 3);
    const MeshTopology topology = topology_of(lattice.mesh);
    const Index3 lo = lattice.anchor - Index3::Constant(resolution / 2);
    const IndexBox box = {lo, lo + Index3::Constant(resolution)};
    const auto samples = static_cast<double>(box.sample_count());

    const auto start = std::chrono::steady_clock::now();
    const KdTree tree(lattice.mesh);
    const KdDenseResult result = dense_distances(lattice, topology, tree, {.box = box});
    const double seconds = seconds_since(start);

    constexpr int row_step = 16;
    std::size_t queries = 0;
    const auto row_start = std::chrono::steady_clock::now();
    for (int z = 0; z < resolution; z += row_step)
        for (int y = 0; y < resolution; y += row_step) {
            double bound = std::numeric_limits<double>::infinity();
            for (int x = 0; x < resolution; ++x, ++queries) {
                const Vec3d p = (lo - lattice.anchor + Index3(x, y, z)).cast<double>();
                // One voxel on, the distance is at most one more.
                bound = std::sqrt(tree.closest(p, bound)->closest.squared_distance) + 1.001;
            }
        }
    fmt::print("{} dense {}^3: by blocks {:.2f} s, {:.0f} ns a sample, {:.2f} distances a sample; "
               "a query a sample {:.0f} ns on one thread\n",
               name, resolution, seconds, seconds / samples * 1e9,
               static_cast<double>(result.distance_evaluations) / samples,
               seconds_since(row_start) / static_cast<double>(queries) * 1e9);
}

} // namespace
} // namespace isocast

int main(int argc, char** argv) {
    using namespace isocast;
    try {
        fmt::print("| mesh | query | tree | build ms | nodes visited | objects tested | ns a query "
                   "|\n| --- | --- | --- | --- | --- | --- | --- |\n");
        if (argc == 1)
            for (const std::string& name : sample_mesh_names())
                print_queries(name, check(sample_mesh(name)).mesh);
        for (int i = 1; i < argc; ++i)
            print_queries(std::filesystem::path(argv[i]).stem(), check(read_mesh(argv[i])).mesh);
        fmt::print("\n");
        if (argc == 1)
            for (const std::string& name : sample_mesh_names())
                print_dense(name, check(sample_mesh(name)).mesh, 256);
        for (int i = 1; i < argc; ++i)
            print_dense(std::filesystem::path(argv[i]).stem(), check(read_mesh(argv[i])).mesh, 256);
    } catch (const std::exception& error) {
        fmt::print(stderr, "bench_kd_tree: {}\n", error.what());
        return 1;
    }
}
