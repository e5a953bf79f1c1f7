// The thesis's own polyhedra: table 4.1, and what scanning them misses of the exact band.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"
#include "distance_transform/csc.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/printed_prisms.h"
#include "distance_transform/sample_meshes.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>

namespace {

using namespace isocast;

Mesh mesh_named(const std::string& name) {
    if (name.starts_with("mesh:")) return sample_mesh(name.substr(5));
    return read_mesh(name);
}

void print_counts(const std::string& name, const Mesh& mesh) {
    try {
        const CoveringCounts counts = Prisms(mesh, 1, Gaps::Leave).counts();
        fmt::print("{:30} {:8} {:8} {:8}\n", name, counts.vertices, counts.saddles, counts.gaps);
    } catch (const InputError& error) {
        fmt::print("{:30} {}\n", name, error.what());
    }
}

/// Seconds that `work` takes, and its result.
template<class Work>
auto timed(const Work& work) {
    const auto start = std::chrono::steady_clock::now();
    auto result = work();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    return std::pair{std::move(result), taken.count()};
}

/// band  half width: in voxels, or, below 1, as a part of the longest side
void print_errors(const std::string& name, const CheckedMesh& checked, int resolution,
                  double band) {
    // Nine voxels of border, as in the figures that the project compares with.
    const double voxel = voxel_size_for_resolution(bounding_box(checked.mesh), resolution - 9);
    const double half_width = band < 1 ? band * (resolution - 9) : band;
    const LatticeMesh lattice = on_lattice(checked.mesh, voxel, half_width);
    constexpr double no_limit = std::numeric_limits<double>::infinity();
    const auto [exact, exact_seconds] = timed([&] {
        return convert(checked, {.voxel_size_world = voxel,
                                 .half_width_voxels = half_width,
                                 .sign = SignMethod::Normal});
    });
    const auto print_row = [&](const char* method, const BandErrors& errors,
                               std::int64_t evaluations, double seconds) {
        fmt::print("{:30} {:5} {:6.1f} {:16} {:9} {:8} {:8} {:8} {:6} {:9.2g} {:8.2f} {:7.2f}\n",
                   name, resolution, half_width, method, errors.samples, errors.missing,
                   errors.too_far, errors.extra, errors.wrong_signs, errors.worst_voxels,
                   static_cast<double>(evaluations) / static_cast<double>(errors.samples), seconds);
        std::fflush(stdout);
    };
    std::vector<FieldBlock> truth(exact.field.blocks().begin(), exact.field.blocks().end());
    for (FieldBlock& block : truth) block.coordinate -= lattice.anchor / block_size;
    print_row("exact", band_errors(truth, truth, voxel), exact.distance_evaluations, exact_seconds);
    const auto print_method = [&](const char* method, const auto& transform) {
        const auto [found, seconds] = timed(transform);
        print_row(method, band_errors(truth, found.blocks, voxel), found.distance_evaluations,
                  seconds);
    };
    print_method("prisms, gaps",
                 [&] { return scan_convert_prisms(lattice, half_width, Gaps::Leave, no_limit); });
    print_method("prisms, closed",
                 [&] { return scan_convert_prisms(lattice, half_width, Gaps::Close, no_limit); });
    print_method("csc, one thread",
                 [&] { return characteristics_scan_conversion(lattice, half_width, no_limit); });
}

} // namespace

int main(int argc, char** argv) {
    try {
        if (argc < 2) {
            fmt::print(stderr, "usage: bench_prisms MESH… (a file, or mesh:sphere6 and so on)\n");
            return 2;
        }
        std::vector<std::string> names;
        std::vector<CheckedMesh> meshes;
        for (const std::string argument : std::span(argv + 1, argv + argc)) {
            names.push_back(std::filesystem::path(argument).filename().string());
            meshes.push_back(check(mesh_named(argument)));
        }
        fmt::print("Table 4.1: vertices, saddle vertices, vertices with incomplete covering\n");
        for (std::size_t i = 0; i < meshes.size(); ++i) print_counts(names[i], meshes[i].mesh);
        fmt::print("\n{:30} {:>5} {:>6} {:16} {:>9} {:>8} {:>8} {:>8} {:>6} {:>9} {:>8} {:>7}\n",
                   "mesh", "N", "band", "method", "samples", "missing", "too far", "extra", "signs",
                   "worst/vx", "evals/s.", "seconds");
        for (std::size_t i = 0; i < meshes.size(); ++i) {
            const MeshVerdict& verdict = meshes[i].verdict;
            if (!verdict.is_closed() || !verdict.is_oriented()) {
                fmt::print("{:30} {}: no band\n", names[i], verdict.summary());
                continue;
            }
            for (const int resolution : {128, 256})
                for (const double band : {3.0, 0.1})
                    print_errors(names[i], meshes[i], resolution, band);
        }
        return 0;
    } catch (const std::exception& error) {
        fmt::print(stderr, "bench_prisms: {}\n", error.what());
        return 1;
    }
}
