// The peers alone, on one mesh.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"
#include "distance_transform/mesh_files.h"
#include "peers/peers.h"
#include "volume/errors.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace {

using namespace isocast;

struct Peer {
    std::string name;
    PeerFrame (*draw)(const PeerScene&);
};

int differing(const std::vector<bool>& a, const std::vector<bool>& b) {
    int count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
    return count;
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Other renderers of a mesh's distance field");
    std::string path;
    int resolution = 256;
    int size = 512;
    int threads = 2;
    int repeats = 3;
    std::vector<std::string> only;
    app.add_option("MESH", path, "Mesh file")->required();
    app.add_option("--resolution", resolution, "Voxels along the longest side, and nine");
    app.add_option("--size", size, "Width and height of the picture");
    app.add_option("--threads", threads);
    app.add_option("--repeats", repeats);
    app.add_option("--only", only, "Peers: openvdb, vtk, teem, embree");
    CLI11_PARSE(app, argc, argv);

    const CheckedMesh checked = check(read_mesh(path));
    const SparseField field =
        convert(checked, {.voxel_size_world =
                              bounding_box(checked.mesh).size().maxCoeff() / (resolution - 9)})
            .field;
    PeerScene scene = scene_of_the_table(field, resolution);
    scene.size = size;
    scene.threads = threads;
    scene.repeats = repeats;

    fmt::print(
        "{}^3, {}^2 pixels, {} threads, medians of {}; pixels that differ are from the first "
        "peer's\n{:<32} {:>9} {:>9} {:>8} {:>7}\n",
        resolution, size, threads, repeats, "peer", "setup [s]", "frame [s]", "covered", "differ");
    std::optional<std::vector<bool>> first;
    for (const auto& [name, draw] : {Peer{"openvdb", openvdb_peer}, Peer{"embree", embree_peer},
                                     Peer{"vtk", vtk_peer}, Peer{"teem", teem_peer}}) {
        if (!only.empty() && std::ranges::find(only, name) == only.end()) continue;
        PeerFrame frame;
        try {
            frame = draw(scene);
        } catch (const ResourceError& error) { // the others still count
            frame = {.name = name, .note = error.what()};
        }
        if (!frame.was_drawn()) {
            fmt::print("{:<32} {}\n", frame.name, frame.note);
            continue;
        }
        if (!first) first = frame.covered;
        const std::string setup =
            std::isnan(frame.setup_seconds) ? "-" : fmt::format("{:.3f}", frame.setup_seconds);
        fmt::print("{:<32} {:>9} {:>9.3f} {:>6.2f} % {:>7} {}\n", frame.name, setup,
                   frame.frame_seconds, 100 * frame.covered_fraction,
                   differing(*first, frame.covered), frame.note);
        std::fflush(stdout);
    }
}
