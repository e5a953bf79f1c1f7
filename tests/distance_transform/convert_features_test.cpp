// What convert() offers beside the signed band: closest points, unsigned fields, full grids,
// estimates, and the same bits from every instruction set.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/band_tiles.h"
#include "distance_transform/brute_force.h"
#include "distance_transform/lattice.h"
#include "distance_transform/pseudonormals.h"
#include "distance_transform/sample_meshes.h"
#include "distance_transform/sites.h"
#include "fields.h"
#include "volume/errors.h"
#include "volume/sweep.h"

#include <bitset>
#include <random>

namespace isocast::test {
namespace {

ConvertOptions at_resolution(const CheckedMesh& mesh, int resolution) {
    return {.voxel_size_world = voxel_size_for_resolution(bounding_box(mesh.mesh), resolution)};
}

/// Distance from `p` to feature `number` of the cleaned mesh, as ClosestBlock numbers them.
double distance_to_feature(const CheckedMesh& mesh, std::int32_t number, const Vec3d& p) {
    const auto& vertices = mesh.mesh.vertices_world;
    const auto faces = static_cast<std::int32_t>(mesh.mesh.triangles.size());
    const auto edges = static_cast<std::int32_t>(mesh.topology.edge_count());
    if (number >= faces + edges) return (p - vertices[number - faces - edges]).norm();
    if (number >= faces) {
        const std::uint32_t halfedge = mesh.topology.edge(number - faces)[0];
        const int a = halfedge_from(mesh.mesh, halfedge);
        const int b = halfedge_to(mesh.mesh, halfedge);
        return brute_force_distance({{vertices[a], vertices[b]}, {{0, 1, 1}}}, p);
    }
    const auto [a, b, c] = mesh.mesh.triangles[number];
    return brute_force_distance({{vertices[a], vertices[b], vertices[c]}, {{0, 1, 2}}}, p);
}

TEST(ConvertClosest, PointsAndFeaturesAreAtTheDistance) {
    for (const char* name : {"knot", "torus"}) {
        const CheckedMesh mesh = check(sample_mesh(name));
        ConvertOptions options = at_resolution(mesh, 48);
        options.closest = true;
        const ConvertResult result = convert(mesh, options);
        ASSERT_EQ(result.closest.size(), result.field.blocks().size());
        const double voxel = options.voxel_size_world;
        std::array<std::int64_t, 3> count{}; // faces, edges, vertices
        const auto faces = static_cast<std::int32_t>(mesh.mesh.triangles.size());
        const auto edges = static_cast<std::int32_t>(mesh.topology.edge_count());
        for (std::size_t b = 0; b < result.closest.size(); ++b) {
            const FieldBlock& block = result.field.blocks()[b];
            const ClosestBlock& closest = result.closest[b];
            for (int i = 0; i < samples_per_block; i += 5) {
                if (!block.active[i]) {
                    ASSERT_EQ(closest.feature[i], -1);
                    ASSERT_EQ(closest.offset_world[i].norm(), 0);
                    continue;
                }
                const Vec3d p = result.field.space().to_world(
                    (block_size * block.coordinate + Index3(i % 8, i / 8 % 8, i / 64))
                        .cast<double>());
                const double distance = std::abs(double{block.values[i]});
                // Rounding to float of a value, and of three components.
                ASSERT_NEAR(closest.offset_world[i].cast<double>().norm(), distance, 1e-6 * voxel);
                ASSERT_NEAR(distance_to_feature(mesh, closest.feature[i], p), distance,
                            1e-6 * voxel);
                const Vec3d q = p + closest.offset_world[i].cast<double>();
                ASSERT_LT(distance_to_feature(mesh, closest.feature[i], q), 1e-6 * voxel);
                ++count[closest.feature[i] < faces           ? 0
                        : closest.feature[i] < faces + edges ? 1
                                                             : 2];
            }
        }
        for (const std::int64_t n : count) EXPECT_GT(n, 0);
    }
}

TEST(ConvertUnsigned, HasTheDistancesOfTheSignedField) {
    const CheckedMesh mesh = check(sample_mesh("knot"));
    ConvertOptions options = at_resolution(mesh, 40);
    const ConvertResult with_sign = convert(mesh, options);
    options.sign = SignMethod::Unsigned;
    const ConvertResult without = convert(mesh, options);
    EXPECT_EQ(without.field.outside(), Outside::Background);
    EXPECT_FALSE(without.field.half_width_world().has_value());
    ASSERT_EQ(without.field.blocks().size(), with_sign.field.blocks().size());
    for (std::size_t b = 0; b < without.field.blocks().size(); ++b) {
        ASSERT_EQ(without.field.blocks()[b].active, with_sign.field.blocks()[b].active);
        for (int i = 0; i < samples_per_block; ++i)
            ASSERT_EQ(without.field.blocks()[b].values[i],
                      std::abs(with_sign.field.blocks()[b].values[i]));
    }
}

TEST(ConvertAuto, SeveralShellsGoByWindingNumber) {
    Mesh two = sample_mesh("torus");
    const Mesh one = two;
    const int count = static_cast<int>(one.vertices_world.size());
    const double apart = 1.5 * bounding_box(one).size().x();
    for (const Vec3d& p : one.vertices_world) two.vertices_world.push_back(p + Vec3d(apart, 0, 0));
    for (const auto& [a, b, c] : one.triangles)
        two.triangles.push_back({a + count, b + count, c + count});
    const CheckedMesh mesh = check(two);
    const ConvertOptions options = at_resolution(mesh, 60);
    const ConvertResult result = convert(mesh, options);
    EXPECT_EQ(result.sign_used, SignMethod::Winding);
    EXPECT_EQ(result.sign_reason, "the mesh has 2 shells");
    EXPECT_TRUE(result.warnings.empty());
    ConvertOptions by_normal = options;
    by_normal.sign = SignMethod::Normal;
    const auto expected = band_map(convert(mesh, by_normal).field);
    const auto found = band_map(result.field);
    ASSERT_EQ(found.size(), expected.size());
    for (const auto& [index, value] : found) {
        ASSERT_EQ(std::abs(value), std::abs(expected.at(index)));
        // 1e-9 voxel: nearer to the surface rounding decides which side a sample is on.
        if (std::abs(value) > 1e-9 * options.voxel_size_world) {
            ASSERT_EQ(value, expected.at(index));
        }
    }
}

TEST(ConvertMethods, ComparisonMethodsKeepTheirDistances) {
    const CheckedMesh mesh = check(sample_mesh("sphere6"));
    ConvertOptions options = at_resolution(mesh, 32);
    const auto exact = band_map(convert(mesh, options).field);
    options.method = BandMethod::Csc;
    expect_same_band(exact, band_map(convert(mesh, options).field));
    options.method = BandMethod::PrintedPrisms;
    const auto printed = band_map(convert(mesh, options).field);
    // Printed prisms miss samples or find them too far, never too near.
    EXPECT_LE(printed.size(), exact.size());
    for (const auto& [index, value] : printed)
        ASSERT_GE(std::abs(value), std::abs(exact.at(index)) - ulp(value));
    options.sign = SignMethod::Winding;
    EXPECT_THROW(convert(mesh, options), InputError);
}

TEST(ConvertEstimate, IsNearTheTruthForSmoothSurfaces) {
    for (const char* name : {"sphere6", "torus"}) {
        const CheckedMesh mesh = check(sample_mesh(name));
        for (const int resolution : {64, 200}) {
            const ConvertOptions options = at_resolution(mesh, resolution);
            const ConvertEstimate expected = estimate(mesh, options);
            const ConvertResult result = convert(mesh, options);
            // Measured: within 3 % (samples) and 6 % (blocks).
            EXPECT_NEAR(expected.active_voxels / double(result.field.active_voxel_count()), 1,
                        0.05);
            EXPECT_NEAR(expected.blocks / double(result.field.blocks().size()), 1, 0.1);
        }
    }
}

TEST(ConvertEstimate, MemoryThatIsNotAllowedIsRefusedBeforehand) {
    const CheckedMesh mesh = check(sample_mesh("sphere6"));
    ConvertOptions options = at_resolution(mesh, 128);
    options.memory_bytes = 0.9 * estimate(mesh, options).peak_bytes;
    EXPECT_THROW(convert(mesh, options), ResourceError);
    options.memory_bytes = 1.1 * estimate(mesh, options).peak_bytes;
    EXPECT_NO_THROW(convert(mesh, options));
}

TEST(ConvertDense, EqualsTheBandWithinIt) {
    const CheckedMesh mesh = check(sample_mesh("torus"));
    const ConvertOptions options = at_resolution(mesh, 40);
    const ConvertResult band = convert(mesh, options);
    const DenseConvertResult dense = convert_dense(mesh, options);
    EXPECT_EQ(dense.field.extent(), dense_box(mesh, options));
    for (const auto& [index, value] : band_samples(band.field))
        // 1e-12 voxel: two ways of rounding in double, near the surface.
        ASSERT_NEAR(sample(dense.field, index), value,
                    ulp(value) + 1e-12 * options.voxel_size_world);
}

TEST(Sweep, KeepsTheBandAndContinuesItAtSlopeOne) {
    const CheckedMesh mesh = check(sample_mesh("sphere6")); // of radius 1 about the origin
    const ConvertOptions options = at_resolution(mesh, 40);
    const ConvertResult band = convert(mesh, options);
    const DenseField full = extend_by_sweeping(band.field, dense_box(mesh, options));
    for (const auto& [index, value] : band_samples(band.field))
        ASSERT_EQ(sample(full, index), value);
    const IndexBox box = full.extent();
    double worst = 0;
    for (int z = box.lo.z(); z < box.hi.z(); ++z)
        for (int y = box.lo.y(); y < box.hi.y(); ++y)
            for (int x = box.lo.x(); x < box.hi.x(); ++x) {
                const Vec3d p = full.space().to_world(Vec3d(x, y, z));
                worst = std::max(worst, std::abs(sample(full, {x, y, z}) - (p.norm() - 1)));
            }
    // First order upwind, over up to 20 voxels of way: measured 1.19 voxels.
    EXPECT_LT(worst / options.voxel_size_world, 1.5);
    EXPECT_THROW(extend_by_sweeping(band.field, {}), InputError);
}

/// Columns of one tile, with the numbers of sites.
struct TileMemory {
    std::vector<double> memory = std::vector<double>(6 * TileColumns::count);
    TileColumns columns{};

    TileMemory() {
        for (int axis = 0; axis < 3; ++axis) {
            columns.signed_square[axis] = &memory[axis * TileColumns::count];
            columns.site[axis] = &memory[(3 + axis) * TileColumns::count];
        }
    }
};

class ScanKernel : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(ScanKernel, ComputesTheBitsOfTheBaseline) {
    if (!is_available(GetParam())) GTEST_SKIP() << "this machine lacks the instruction set";
    for (const std::string name : {"knot", "seashell"}) { // the seashell has borders
        const CheckedMesh mesh = check(sample_mesh(name));
        const LatticeMesh lattice =
            on_lattice(mesh.mesh, voxel_size_for_resolution(bounding_box(mesh.mesh), 50), 4);
        const Sites sites(lattice.mesh, mesh.topology, 4, InstructionSet::Baseline);
        const Sites others(lattice.mesh, mesh.topology, 4, GetParam());
        for (int f = 0; f < sites.arrays().fan_count; ++f) {
            const FanData& fan = sites.arrays().fans[f];
            const FanData& other = others.arrays().fans[f];
            ASSERT_TRUE(std::ranges::equal(fan.normal, other.normal));
            ASSERT_EQ(fan.slope_above, other.slope_above);
            ASSERT_EQ(fan.slope_below, other.slope_below);
        }
        const BandTiles band = find_band_tiles(sites, 1e9, {});
        ASSERT_EQ(find_band_tiles(others, 1e9, {}).sites, band.sites);
        TileMemory tile_memory;
        TileMemory other_memory;
        for (const BandTile& tile : band.tiles) {
            const auto list = band.sites_of(tile);
            const Vec3d first = tile_size * tile.coordinate.cast<double>();
            TileInput input{.sites = &sites.arrays(),
                            .list = list.data(),
                            .count = std::ssize(list),
                            .first_sample = {first.x(), first.y(), first.z()}};
            const std::int64_t evaluations = sites.kernels().scan(input, tile_memory.columns);
            input.sites = &others.arrays();
            ASSERT_EQ(others.kernels().scan(input, other_memory.columns), evaluations);
            for (int b = 0; b < 64; ++b) {
                ScannedBlock block{};
                ScannedBlock other{};
                const bool is_active = sites.kernels().finish(tile_memory.columns, 4, 0.1, b % 4,
                                                              b / 4 % 4, b / 16, block);
                ASSERT_EQ(others.kernels().finish(other_memory.columns, 4, 0.1, b % 4, b / 4 % 4,
                                                  b / 16, other),
                          is_active);
                ASSERT_TRUE(std::ranges::equal(block.distance, other.distance));
                ASSERT_TRUE(std::ranges::equal(block.active, other.active));
                ASSERT_TRUE(std::ranges::equal(block.negative, other.negative));
                ASSERT_TRUE(std::ranges::equal(block.site, other.site));
                // Every block with a sample of the band was foretold.
                ASSERT_TRUE(!is_active || (tile.blocks >> b & 1));
                float with_signs[2][512];
                sites.kernels().apply_signs(block.distance, block.negative, with_signs[0]);
                others.kernels().apply_signs(block.distance, block.negative, with_signs[1]);
                ASSERT_TRUE(std::ranges::equal(with_signs[0], with_signs[1]));
            }
        }
    }
}

TEST(Sites, NormalsOfVerticesAreThoseOfExactAngles) {
    const CheckedMesh mesh = check(sample_mesh("knot"));
    const Sites sites(mesh.mesh, mesh.topology, 1);
    const Pseudonormals pseudonormals(mesh.mesh, mesh.topology);
    for (std::size_t c = 0; c < mesh.topology.fan_of_corner.size(); ++c) {
        const Vec3d& expected =
            pseudonormals.at(static_cast<int>(c / 3), std::array{Feature::Vertex0, Feature::Vertex1,
                                                                 Feature::Vertex2}[c % 3]);
        const Eigen::Map<const Vec3d> normal(
            sites.arrays().fans[mesh.topology.fan_of_corner[c]].normal);
        // A few roundings of each of some six angles and normals.
        ASSERT_LT((normal - expected).norm(), 1e-14 * expected.norm());
    }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, ScanKernel,
                         ::testing::Values(InstructionSet::Avx2, InstructionSet::Avx512),
                         [](const auto& test) {
                             return test.param == InstructionSet::Avx2 ? "Avx2" : "Avx512";
                         });

} // namespace
} // namespace isocast::test
