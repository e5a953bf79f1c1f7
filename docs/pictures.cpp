// docs_pictures FOLDER: the slices, and the prisms as meshes, of distance_transform.md.
// SPDX-License-Identifier: MPL-2.0
#include "docs/program.h"
#include "docs/slice.h"

#include "distance_transform/convert.h"
#include "distance_transform/kd_dense.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/prism.h"
#include "distance_transform/sample_meshes.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <numbers>

namespace {

using namespace isocast;

Vec3d ring_point(double degrees, double radius, double z) {
    const double angle = degrees * std::numbers::pi / 180;
    return {radius * std::cos(angle), radius * std::sin(angle), z};
}

/// Triangles around vertex 0, at the origin, in the order of its neighbours.
Mesh fan_of(const std::vector<Vec3d>& neighbours) {
    Mesh mesh;
    mesh.vertices_world.push_back(Vec3d::Zero());
    mesh.vertices_world.insert(mesh.vertices_world.end(), neighbours.begin(), neighbours.end());
    const int count = static_cast<int>(neighbours.size());
    for (int i = 0; i < count; ++i) mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % count});
    return mesh;
}

/// A saddle that leaves a gap, as in thesis figure 4.5: neighbours go up and down by turns, each
/// way up is wide and each way down narrow, so that all bisector planes lean to the same side.
Mesh saddle_of_eight() {
    std::vector<Vec3d> neighbours;
    for (int i = 0; i < 8; ++i)
        neighbours.push_back(
            ring_point(90 * (i / 2) + (i % 2 == 0 ? 0 : 65), 1, i % 2 == 0 ? -0.3 : 0.3));
    return fan_of(neighbours);
}

Mesh convex_of_six() {
    std::vector<Vec3d> neighbours;
    for (int i = 0; i < 6; ++i) neighbours.push_back(ring_point(60 * i, 1, -0.45));
    return fan_of(neighbours);
}

/// Writes the printed prisms of all triangles, each a little smaller so that it can be told apart.
void write_prisms(const Mesh& mesh, Gaps gaps, const std::filesystem::path& path) {
    constexpr double half_width = 0.4;
    constexpr double size = 0.97;
    const Prisms prisms(mesh, half_width, gaps);
    Mesh all;
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
        const Mesh prism = prism_mesh(mesh, prisms, std::span(&t, 1));
        Vec3d middle = Vec3d::Zero();
        for (const Vec3d& p : prism.vertices_world)
            middle += p / static_cast<double>(prism.vertices_world.size());
        const int first = static_cast<int>(all.vertices_world.size());
        for (const Vec3d& p : prism.vertices_world)
            all.vertices_world.push_back(middle + size * (p - middle));
        for (const auto& [a, b, c] : prism.triangles)
            all.triangles.push_back({first + a, first + b, first + c});
    }
    write_mesh(all, path);
}

/// The samples at height z of a square `width` wide around the middle of the mesh.
IndexBox slice_box(const CheckedMesh& mesh, double voxel, double z_world, int width) {
    const WorldBox box = bounding_box(mesh.mesh);
    const Vec3d middle = (box.min + box.max) / 2 / voxel;
    const Index3 lo(static_cast<int>(middle.x()) - width / 2,
                    static_cast<int>(middle.y()) - width / 2,
                    static_cast<int>(std::floor(z_world / voxel)));
    return {lo, lo + Index3(width, width, 1)};
}

void draw(const FieldSource& field, double voxel, double background_voxels, SliceCanvas& slice) {
    std::vector<float> values(static_cast<std::size_t>(slice.box().sample_count()));
    field.copy_box(slice.box(), 0, values);
    const int width = slice.box().size().x();
    for (std::size_t i = 0; i < values.size(); ++i) {
        const Index3 offset(static_cast<int>(i) % width, static_cast<int>(i) / width, 0);
        const double d = values[i] / voxel;
        // Where a band ends, so do its stripes.
        const Colour colour = std::abs(d) < background_voxels - 1e-3 ? distance_colour(d)
                              : d < 0                                ? Colour(0.80f, 0.87f, 0.95f)
                                                                     : Colour(0.98f, 0.94f, 0.89f);
        slice.set(slice.box().lo + offset, colour);
    }
}

void write_field_slices(const CheckedMesh& mesh, double z_world,
                        const std::filesystem::path& path) {
    constexpr int width = 392;
    const ConvertOptions options{
        .voxel_size_world = voxel_size_for_resolution(bounding_box(mesh.mesh), width * 9 / 10),
        .half_width_voxels = 12};
    const double voxel = options.voxel_size_world;
    SliceCanvas band(slice_box(mesh, voxel, z_world, width));
    draw(convert(mesh, options).field, voxel, options.half_width_voxels, band);

    SliceCanvas full(band.box());
    const LatticeMesh lattice = on_lattice(mesh.mesh, voxel, options.half_width_voxels);
    const KdDenseResult dense =
        dense_distances(lattice, mesh.topology, KdTree(lattice.mesh), {.box = full.box()});
    draw(dense.field, voxel, std::numeric_limits<double>::infinity(), full);
    write_png(beside(band.image(), full.image()), path);
}

/// Cyan faces, blue edges, red vertices, as the polyhedra of thesis figure 4.3.
Colour feature_colour(const MeshTopology& topology, std::size_t face_count, std::size_t feature) {
    // Multiples of the golden ratio: neighbouring numbers get shades far apart.
    const double turns = static_cast<double>(feature) * std::numbers::phi;
    const auto shade = static_cast<float>(0.65 + 0.35 * (turns - std::floor(turns)));
    if (feature < face_count) return shade * Colour(0.62f, 0.92f, 0.95f);
    if (feature < face_count + topology.edge_count()) return shade * Colour(0.25f, 0.45f, 0.95f);
    return shade * Colour(0.95f, 0.25f, 0.20f);
}

void write_voronoi_slice(const CheckedMesh& mesh, double z_world,
                         const std::filesystem::path& path) {
    constexpr int width = 640;
    const ConvertOptions options{
        .voxel_size_world = voxel_size_for_resolution(bounding_box(mesh.mesh), width * 9 / 10),
        .half_width_voxels = 28,
        .closest = true};
    const ConvertResult result = convert(mesh, options);
    SliceCanvas slice(slice_box(mesh, options.voxel_size_world, z_world, width));
    for (std::size_t b = 0; b < result.closest.size(); ++b) {
        const FieldBlock& block = result.field.blocks()[b];
        for (int i = 0; i < samples_per_block; ++i) {
            const Index3 sample = block_size * block.coordinate + Index3(i % 8, i / 8 % 8, i / 64);
            const int feature = result.closest[b].feature[i];
            if (!slice.box().contains(sample) || feature < 0) continue;
            const bool is_surface = std::abs(block.values[i]) < options.voxel_size_world;
            slice.set(sample, is_surface ? Colour::Zero()
                                         : feature_colour(mesh.topology, mesh.mesh.triangles.size(),
                                                          static_cast<std::size_t>(feature)));
        }
    }
    write_png(slice.image(), path);
}

} // namespace

int main(int argc, char** argv) {
    return run_program(argc, "docs_pictures FOLDER", [&] {
        const std::filesystem::path folder = argv[1];
        write_prisms(convex_of_six(), Gaps::Leave, folder / "prisms_convex.ply");
        write_prisms(saddle_of_eight(), Gaps::Leave, folder / "prisms_gap.ply");
        write_prisms(saddle_of_eight(), Gaps::Close, folder / "prisms_closed.ply");
        const CheckedMesh knot = check(sample_mesh("knot"));
        write_field_slices(knot, 0.35, folder / "slices.png");
        write_voronoi_slice(knot, 0.35, folder / "voronoi.png");
    });
}
