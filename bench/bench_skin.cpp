// Skins of molecules beside their solvent-excluded surfaces as fields: what each takes, and how far
// they are apart.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/reconstruct.h"
#include "quadrics/molecular_surface.h"
#include "quadrics/molecule_styles.h"
#include "quadrics/quadrics_bench.h"
#include "quadrics/skin/skin_surface.h"
#include "volume/stopwatch.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace {

using namespace isocast;

constexpr int size = 512; // of pictures [pixels]

struct Seen {
    std::vector<Vec3d> hits_world;
    double frame_seconds = 0;
    double mib = 0;
};
/// From six sides.
Seen seen(Renderer& renderer, int repeats) {
    Seen out;
    for (int side = 0; side < 6; ++side) {
        Vec3d from = 0.1 * Vec3d(0.3, 0.5, 0.7);
        from[side / 2] += side % 2 == 0 ? 1 : -1;
        const Camera camera = frame_box(renderer.surface_points_world(), from, 1, 30);
        renderer.draw(camera, size, size, {FrameImage::Hit});
        const Image hits = renderer.read(FrameImage::Hit);
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4)
            if (hits.rgba[i + 3] != 0)
                out.hits_world.push_back(
                    camera.eye_world +
                    Eigen::Map<const Eigen::Vector3f>(&hits.rgba[i]).cast<double>());
        if (side > 0) continue;
        out.frame_seconds = median_frame_seconds(renderer, camera, size, size, repeats);
        const FrameReport report = renderer.draw(camera, size, size, {FrameImage::Beauty});
        out.mib = double(report.field_bytes + report.splat_bytes) / (1 << 20);
    }
    return out;
}

/// How far hits are off a distance field, out of it above 0.
void print_off(const FieldSource& field, const std::vector<Vec3d>& hits_world) {
    std::vector<double> off;
    double sum = 0;
    for (const Vec3d& p : hits_world)
        off.push_back(kernel_value(field, field.space().to_index(p), Kernel::Linear));
    for (const double d : off) sum += d * d;
    std::ranges::sort(off);
    const auto at = [&](double share) {
        return off[static_cast<std::size_t>(share * double(off.size() - 1))];
    };
    fmt::print(" {:.3f} {:.3f} {:.3f} {:.3f} {:.3f} {:.3f}", at(0), at(0.01), at(0.5), at(0.99),
               at(1), std::sqrt(sum / double(off.size())));
}

void compare(Renderer& renderer, const std::string& path, const std::vector<double>& shrinks,
             int repeats) {
    const std::vector<Sphere> atoms =
        primitives_of(read_molecule(path), {.style = MoleculeStyle::SpaceFilling}).spheres;
    const SparseField truth =
        molecular_surface(atoms, {.voxel_size_world = 0.2, .half_width_voxels = 20});
    fmt::print("{}, {} atoms: tetrahedra, seconds to make and of a frame, MiB; off the excluded "
               "surface [angstrom]: least, 1 %, median, 99 %, greatest, RMS\n",
               std::filesystem::path(path).filename().string(), atoms.size());
    for (const double voxel : {0.5, 0.25}) {
        const Stopwatch time;
        auto field =
            std::make_shared<SparseField>(molecular_surface(atoms, {.voxel_size_world = voxel}));
        const double made = time.seconds();
        renderer.load({.field = field});
        const Seen rays = seen(renderer, repeats);
        fmt::print("field@{} - {:.2f} {:.3f} {:.1f}", voxel, made, rays.frame_seconds, rays.mib);
        print_off(truth, rays.hits_world);
        fmt::print("\n");
    }
    for (const double shrink : shrinks) {
        const Stopwatch time;
        TetrahedralMesh mesh = skin_surface(atoms, shrink);
        const double made = time.seconds();
        const std::size_t count = mesh.tetrahedra.size();
        renderer.load({.primitives = std::make_shared<Primitives>(
                           Primitives{.tetrahedra = {std::move(mesh)}})});
        const Seen skin = seen(renderer, repeats);
        fmt::print("skin@{} {} {:.2f} {:.3f} {:.1f}", shrink, count, made, skin.frame_seconds,
                   skin.mib);
        print_off(truth, skin.hits_world);
        fmt::print("\n");
    }
}

} // namespace

int main(int argc, char** argv) try {
    CLI::App app("Skins of molecules beside their solvent-excluded surfaces");
    std::vector<std::string> paths;
    std::vector<double> shrinks{0.25, 0.5, 0.75};
    int repeats = 5;
    app.add_option("MOLECULE", paths, "PDB, mmCIF or XYZ")->required();
    app.add_option("--shrink", shrinks);
    app.add_option("--repeats", repeats);
    CLI11_PARSE(app, argc, argv);
    const auto context = gl::make_context({.backend = gl::Backend::Osmesa});
    Renderer renderer(*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders");
    for (const std::string& path : paths) compare(renderer, path, shrinks, repeats);
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "bench_skin: {}\n", error.what());
    return 1;
}
