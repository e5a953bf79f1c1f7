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

namespace {

using namespace isocast;

Mesh mesh_named(const std::string& name) {
    if (name.starts_with("mesh:")) return sample_mesh(name.substr(5));
    return read_mesh(name);
}

void print_table_4_1(const std::vector<std::string>& names, const std::vector<Mesh>& meshes) {
    fmt::print("Table 4.1: vertices, saddle vertices, vertices with incomplete covering\n");
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const CoveringCounts counts = Prisms(meshes[i], 1, Gaps::Leave).counts();
        fmt::print("{:50} {:8} {:8} {:8}\n", names[i], counts.vertices, counts.saddles,
                   counts.gaps);
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

void print_errors(const std::string& name, const Mesh& mesh, int resolution, double half_width) {
    const WorldBox box = bounding_box(mesh);
    const double voxel = voxel_size_for_resolution(box, resolution);
    const LatticeMesh lattice = on_lattice(mesh, voxel, half_width);
    const CheckedMesh checked = check(mesh);
    const auto [exact, exact_seconds] = timed([&] {
        return convert(checked, {.voxel_size_world = voxel,
                                 .half_width_voxels = half_width,
                                 .sign = SignMethod::Normal});
    });
    const auto print_row = [&](const char* method, const BandErrors& errors,
                               std::int64_t evaluations, double seconds) {
        fmt::print("{:30} {:5} {:6.1f} {:16} {:9} {:8} {:8} {:8} {:6} {:9.2g} {:8.2f} {:7.2f}\n",
                   std::filesystem::path(name).filename().string(), resolution, half_width, method,
                   errors.samples, errors.missing, errors.too_far, errors.extra,
                   errors.wrong_signs, errors.worst_voxels,
                   static_cast<double>(evaluations) / static_cast<double>(errors.samples),
                   seconds);
        std::fflush(stdout);
    };
    std::vector<FieldBlock> truth(exact.field.blocks().begin(), exact.field.blocks().end());
    for (FieldBlock& block : truth) block.coordinate -= lattice.anchor / block_size;
    print_row("exact", band_errors(truth, truth, voxel), exact.distance_evaluations,
              exact_seconds);
    const auto print_method = [&](const char* method, const auto& transform) {
        const auto [band, seconds] = timed(transform);
        print_row(method, band_errors(truth, band.blocks, voxel), band.distance_evaluations,
                  seconds);
    };
    print_method("prisms, gaps", [&] {
        return scan_convert_prisms(lattice, half_width, Gaps::Leave);
    });
    print_method("prisms, closed", [&] {
        return scan_convert_prisms(lattice, half_width, Gaps::Close);
    });
    print_method("csc, one thread", [&] {
        return characteristics_scan_conversion(lattice, half_width);
    });
}

} // namespace

int main(int argc, char** argv) {
    try {
        std::vector<std::string> names(argv + 1, argv + argc);
        if (names.empty()) {
            fmt::print(stderr, "usage: bench_prisms MESH… (a file, or mesh:sphere6 and so on)\n");
            return 2;
        }
        std::vector<Mesh> meshes;
        for (const std::string& name : names) meshes.push_back(check(mesh_named(name)).mesh);
        print_table_4_1(names, meshes);
        fmt::print("\n{:30} {:>5} {:>6} {:16} {:>9} {:>8} {:>8} {:>8} {:>6} {:>9} {:>8} {:>7}\n",
                   "mesh", "N", "band", "method", "samples", "missing", "too far", "extra",
                   "signs", "worst/vx", "evals/s.", "seconds");
        for (std::size_t i = 0; i < meshes.size(); ++i)
            for (const int resolution : {128, 256})
                for (const double half_width : {3.0, 0.1 * resolution})
                    print_errors(names[i], meshes[i], resolution, half_width);
        return 0;
    } catch (const std::exception& error) {
        fmt::print(stderr, "bench_prisms: {}\n", error.what());
        return 1;
    }
}
