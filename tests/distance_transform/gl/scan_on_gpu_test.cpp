// Scan conversion on the GPU against the CPU's, block by block.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/gl/scan_on_gpu.h"

#include "distance_transform/checked_mesh.h"
#include "distance_transform/convert.h"
#include "distance_transform/lattice.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "distance_transform/tile_transform.h"
#include "test_context.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <ostream>

namespace isocast {
namespace {

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";
constexpr double no_limit = std::numeric_limits<double>::infinity();

/// A mesh on its lattice, ready to be scanned by either.
struct Prepared {
    CheckedMesh input;
    double voxel_size;
    LatticeMesh lattice;
    Sites sites;
    BandTiles band;
    std::optional<WindingNumber> winding;

    Prepared(CheckedMesh mesh, int resolution, double half_width)
        : input(std::move(mesh)),
          voxel_size(voxel_size_for_resolution(bounding_box(input.mesh), resolution)),
          lattice(on_lattice(input.mesh, voxel_size, half_width)),
          sites(lattice.mesh, input.topology, half_width),
          band(find_band_tiles(sites, no_limit, {})) {
        const bool is_closed = input.verdict.is_closed() && input.verdict.is_oriented();
        if (!is_closed) winding.emplace(lattice.mesh, false);
    }

    FieldBlocks on_cpu() const {
        TileTransform transform(sites, {.winding = winding ? &*winding : nullptr}, voxel_size,
                                band.block_count);
        for (const BandTile& tile : band.tiles) transform.run(tile, band.sites_of(tile));
        return transform.take().blocks;
    }

    GpuScan on_gpu(gl::Context& context, const GpuScanOptions& options = {}) const {
        gl::ShaderLibrary shaders({shader_folder});
        return scan_on_gpu(context, shaders, sites, band, winding ? &*winding : nullptr, voxel_size,
                           options);
    }
};

struct Differences {
    std::int64_t active = 0;   // samples, of the first
    std::int64_t activity = 0; // active in one only
    std::int64_t signs = 0;
    std::int64_t values = 0;      // whose bits differ
    double greatest_distance = 0; // between two values [voxels]
};

Differences differences(const FieldBlocks& a, const FieldBlocks& b, double voxel_size) {
    Differences result;
    EXPECT_EQ(a.size(), b.size());
    if (a.size() != b.size()) return result;
    const auto in_a = zyx_order(a);
    const auto in_b = zyx_order(b);
    for (std::size_t i = 0; i < a.size(); ++i) {
        const FieldBlock& one = a[in_a[i]];
        const FieldBlock& other = b[in_b[i]];
        EXPECT_EQ(one.coordinate, other.coordinate);
        result.active += static_cast<std::int64_t>(one.active.count());
        result.activity += static_cast<std::int64_t>((one.active ^ other.active).count());
        for (int k = 0; k < samples_per_block; ++k) {
            const float x = one.values[k];
            const float y = other.values[k];
            result.signs += std::signbit(x) != std::signbit(y);
            result.values += std::memcmp(&x, &y, sizeof x) != 0;
            // A value that is no number must not slip through.
            const double distance =
                std::isfinite(y) ? std::abs(double{x} - y) / voxel_size : no_limit;
            result.greatest_distance = std::max(result.greatest_distance, distance);
        }
    }
    return result;
}

/// Same active samples and signs, and the same bits but for exact ties, of which the CPU's kernel
/// may take another: its doubles differ in their last bits, and so do one in 2^29 of the floats
/// that these are rounded to. Hence at most one, within the 1e-5 voxel that the project promises.
Differences expect_the_cpus_samples(const Prepared& prepared, const GpuScan& gpu) {
    const Differences found = differences(prepared.on_cpu(), gpu.blocks, prepared.voxel_size);
    EXPECT_GT(found.active, 10000);
    EXPECT_EQ(found.activity, 0);
    EXPECT_EQ(found.signs, 0);
    EXPECT_LE(found.values, 1);
    EXPECT_LE(found.greatest_distance, 1e-5);
    return found;
}

struct Case {
    std::string name;
    int resolution;
    double half_width;
};

void PrintTo(const Case& c, std::ostream* out) {
    *out << c.name << " at " << c.resolution << " within " << c.half_width;
}

std::string name_of_case(const testing::TestParamInfo<Case>& info) {
    std::string name = info.param.name;
    std::erase_if(name, [](char c) { return c == '-' || c == '.' || c == ':'; });
    return name + "At" + std::to_string(info.param.resolution) + "Within" +
           std::to_string(static_cast<int>(info.param.half_width));
}

/// A third of a sphere's triangles taken out.
Mesh open_sphere() {
    Mesh mesh = sample_mesh("sphere6");
    mesh.triangles.resize(mesh.triangles.size() * 2 / 3);
    return mesh;
}

std::optional<CheckedMesh> mesh_named(const std::string& name) {
    if (name == "open") return check(open_sphere());
    if (!name.ends_with(".obj")) return check(sample_mesh(name));
    const auto path = std::filesystem::path(ISOCAST_SHARED_DATA) / name;
    if (!std::filesystem::exists(path)) return std::nullopt;
    return check(read_mesh(path));
}

struct GpuScanOf : testing::TestWithParam<Case> {
    std::unique_ptr<gl::Context> context = test::make_context();
};

TEST_P(GpuScanOf, HasTheSamplesOfTheCpu) {
    const auto mesh = mesh_named(GetParam().name);
    if (!mesh) GTEST_SKIP() << "no " << GetParam().name << " in " << ISOCAST_SHARED_DATA;
    const Prepared prepared(*mesh, GetParam().resolution, GetParam().half_width);
    const GpuScan gpu = prepared.on_gpu(*context);
    const Differences found = expect_the_cpus_samples(prepared, gpu);
    // Float tells nearly all samples' nearest sites apart: the exact distances are few.
    EXPECT_LT(static_cast<double>(gpu.candidates), 1.2 * static_cast<double>(found.active));
}

INSTANTIATE_TEST_SUITE_P(
    Meshes, GpuScanOf,
    testing::Values(Case{"sphere6", 64, 3}, Case{"sphere6", 96, 8}, Case{"knot", 96, 3},
                    Case{"knot", 64, 8}, Case{"torus", 64, 3}, Case{"torus", 96, 8},
                    Case{"seashell", 96, 3}, Case{"open", 64, 3}, Case{"open", 96, 8},
                    Case{"bunny-closed.obj", 64, 3}, Case{"bunny-closed.obj", 96, 3},
                    Case{"bunny-closed.obj", 64, 8}, Case{"bunny-closed.obj", 96, 8}),
    name_of_case);

/// The knot, whose triangles are long, across many tiles and batches.
struct GpuScanBatches : testing::Test {
    const Prepared prepared{check(sample_mesh("knot")), 96, 8};
    std::unique_ptr<gl::Context> context = test::make_context();
};

void expect_same_bits(const FieldBlocks& a, const FieldBlocks& b) {
    ASSERT_EQ(a.size(), b.size());
    const Differences found = differences(a, b, 1);
    EXPECT_EQ(found.activity, 0);
    EXPECT_EQ(found.values, 0);
}

TEST_F(GpuScanBatches, ImagesOfAnySizeGiveTheSame) {
    const GpuScan whole = prepared.on_gpu(*context);
    ASSERT_EQ(whole.batches, 1);
    const GpuScan parts = prepared.on_gpu(*context, {.target_extent = 128});
    EXPECT_GT(parts.batches, 2);
    expect_same_bits(whole.blocks, parts.blocks);
}

TEST_F(GpuScanBatches, EglAndOsmesaGiveTheSame) {
    const GpuScan osmesa = prepared.on_gpu(*context);
    context.reset();
    std::unique_ptr<gl::Context> egl;
    try {
        egl = gl::make_context({.backend = gl::Backend::Egl});
    } catch (const gl::NoContextError& error) {
        GTEST_SKIP() << error.what();
    }
    expect_same_bits(osmesa.blocks, prepared.on_gpu(*egl).blocks);
}

TEST_F(GpuScanBatches, AnInterruptedScanLeavesTheContextUsable) {
    gl::ShaderLibrary shaders({shader_folder});
    const Progress interrupt = [](std::string_view, double fraction) {
        if (fraction > 0) throw Interrupted();
    };
    EXPECT_THROW(scan_on_gpu(*context, shaders, prepared.sites, prepared.band, nullptr,
                             prepared.voxel_size, {.target_extent = 128}, interrupt),
                 Interrupted);
    expect_the_cpus_samples(prepared, prepared.on_gpu(*context));
}

/// Two sheets a millionth of a voxel apart at 60 voxels to 2.8.
CheckedMesh thin_plate() {
    constexpr double thickness = 4e-8;
    Mesh plate;
    const Vec3d lean = Vec3d(0.3, 0.5, 1).normalized();
    const Vec3d u = lean.unitOrthogonal();
    const Vec3d v = lean.cross(u);
    for (const double side : {-thickness / 2, thickness / 2})
        for (const auto& [a, b] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
            plate.vertices_world.push_back(a * u + b * v + side * lean);
    plate.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                       {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
    return check(plate);
}

/// Float cannot tell the sheets apart, and what is outside of one is not outside of the other.
TEST(GpuScan, SignsOfAThinPlateAreTheCpus) {
    const CheckedMesh mesh = thin_plate();
    ASSERT_TRUE(mesh.verdict.is_closed() && mesh.verdict.is_oriented());
    const auto context = test::make_context();
    const Prepared prepared(mesh, 60, 5);
    const GpuScan gpu = prepared.on_gpu(*context);
    const Differences found = expect_the_cpus_samples(prepared, gpu);
    // Over both sheets both are candidates; a tenth of the band lies beside the plate.
    EXPECT_GT(static_cast<double>(gpu.candidates), 1.5 * static_cast<double>(found.active));
}

TEST(GpuScan, CandidatesThatOverflowAreDrawnAgain) {
    // One tile at a time, with room for half as many candidates as samples; here are twice as many.
    const auto context = test::make_context();
    const Prepared prepared(thin_plate(), 60, 20);
    const GpuScan narrow = prepared.on_gpu(*context, {.target_extent = 1});
    EXPECT_GT(narrow.repeated_batches, 0);
    expect_the_cpus_samples(prepared, narrow);
}

/// Triangles far larger than a tile, and a field that spans many tiles.
TEST(GpuScan, HasTheSamplesOfTheCpuForLongTriangles) {
    Mesh tetrahedron;
    tetrahedron.vertices_world = {{0, 0, 0}, {1, 0.1, 0.05}, {0.1, 0.2, 0.01}, {0.3, 0.1, 0.4}};
    tetrahedron.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    const auto context = test::make_context();
    const Prepared prepared(check(tetrahedron), 400, 3);
    const GpuScan gpu = prepared.on_gpu(*context, {.target_extent = 1024});
    EXPECT_GT(gpu.batches, 3);
    const Differences found = expect_the_cpus_samples(prepared, gpu);
    EXPECT_GT(found.active, 100000);
    EXPECT_LT(static_cast<double>(gpu.candidates), 1.1 * static_cast<double>(found.active));
}

} // namespace
} // namespace isocast
