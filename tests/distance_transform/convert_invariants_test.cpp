// What must not change the field, or change it in a known way.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/brute_force.h"
#include "distance_transform/sample_meshes.h"
#include "fields.h"

#include <tbb/global_control.h>

#include <random>

namespace isocast::test {
namespace {

// With vertices at multiples of 2^-10 and this voxel size, moving by whole voxels and all
// differences of coordinates are exact in double.
constexpr double voxel = 0x1p-4;

/// A torus with its vertices rounded to multiples of 2^-10 and shaken by a few of them.
Mesh dyadic_torus() {
    Mesh mesh = sample_mesh("torus");
    std::mt19937 random(7);
    std::uniform_int_distribution<int> shake(-8, 8);
    for (Vec3d& p : mesh.vertices_world)
        for (double& x : p) x = (std::round(x * 0x1p10) + shake(random)) * 0x1p-10;
    return mesh;
}

template<class Map>
Mesh mapped(Mesh mesh, const Map& map) {
    for (Vec3d& p : mesh.vertices_world) p = map(p);
    return mesh;
}

Mesh turned_round(Mesh mesh) {
    for (std::array<int, 3>& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    return mesh;
}

SparseField field_of(const Mesh& mesh) {
    return convert(check(mesh), {.voxel_size_world = voxel}).field;
}

TEST(ConvertInvariants, WholeVoxelTranslationMovesTheFieldBitForBit) {
    const Mesh mesh = dyadic_torus();
    const Index3 shift(5, -13, 67);
    const Vec3d shift_world = voxel * shift.cast<double>();
    const SparseField moved =
        field_of(mapped(mesh, [&](const Vec3d& p) { return Vec3d(p + shift_world); }));
    EXPECT_EQ(band_map(moved), band_map(field_of(mesh), shift));
}

TEST(ConvertInvariants, FarFromTheOriginNothingIsLost) {
    const Mesh mesh = dyadic_torus();
    const Index3 shift(1 << 26, -(1 << 26), 1 << 25); // about 1e6 times the mesh's size
    const Vec3d shift_world = voxel * shift.cast<double>();
    const SparseField moved =
        field_of(mapped(mesh, [&](const Vec3d& p) { return Vec3d(p + shift_world); }));
    EXPECT_EQ(moved.space().world_from_index.translation(), Vec3d::Zero());
    EXPECT_EQ(band_map(moved), band_map(field_of(mesh), shift));
}

TEST(ConvertInvariants, BeyondIndex2To28TheTransformIsShifted) {
    const Mesh mesh = dyadic_torus();
    const Vec3d shift_world = voxel * Vec3d(0x1p34, 3, -0x1p30);
    const SparseField moved =
        field_of(mapped(mesh, [&](const Vec3d& p) { return Vec3d(p + shift_world); }));
    const Vec3d translation = moved.space().world_from_index.translation();
    EXPECT_GT(translation.x(), 0);
    EXPECT_EQ(translation.y(), 0);
    EXPECT_LT(translation.z(), 0);
    const Vec3d in_voxels = translation / voxel;
    EXPECT_EQ(in_voxels, Vec3d(in_voxels.array().round()));
    const Vec3d shift = (translation - shift_world) / voxel;
    EXPECT_EQ(band_map(moved, shift.cast<int>()), band_map(field_of(mesh)));
}

TEST(ConvertInvariants, FarMeshWithAnyNumbersAgreesWithBruteForce) {
    const Mesh mesh = mapped(sample_mesh("knot"), [](const Vec3d& p) {
        return Vec3d(p + Vec3d(7.3e6, -9.1e6, 6.7e6)); // about 1e6 times its size
    });
    const CheckedMesh checked = check(mesh);
    const SparseField field = convert(checked, {.voxel_size_world = 0.21}).field;
    expect_exact(compare(field, [&](const Vec3d& p) {
        const double distance = brute_force_distance(checked.mesh, p);
        return brute_force_winding_number(checked.mesh, p) > 0.5 ? -distance : distance;
    }));
}

TEST(ConvertInvariants, MirrorImageGivesTheMirroredField) {
    const Mesh mesh = dyadic_torus();
    const Mesh mirrored =
        turned_round(mapped(mesh, [](const Vec3d& p) { return Vec3d(-p.x(), p.y(), p.z()); }));
    std::map<std::array<int, 3>, float> expected;
    for (const auto& [zyx, value] : band_map(field_of(mesh)))
        expected[{zyx[0], zyx[1], -zyx[2]}] = value;
    expect_same_band(band_map(field_of(mirrored)), expected);
}

TEST(ConvertInvariants, QuarterTurnGivesTheTurnedField) {
    const Mesh mesh = dyadic_torus();
    const Mesh turned = mapped(mesh, [](const Vec3d& p) { return Vec3d(p.z(), p.y(), -p.x()); });
    std::map<std::array<int, 3>, float> expected;
    for (const auto& [zyx, value] : band_map(field_of(mesh)))
        expected[{-zyx[2], zyx[1], zyx[0]}] = value;
    expect_same_band(band_map(field_of(turned)), expected);
}

TEST(ConvertInvariants, OrderOfTrianglesAndCornersDoesNotMatter) {
    Mesh mesh = dyadic_torus();
    const auto expected = band_map(field_of(mesh));
    std::mt19937 random(11);
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
    for (std::array<int, 3>& triangle : mesh.triangles)
        std::rotate(triangle.begin(), triangle.begin() + random() % 3, triangle.end());
    expect_same_band(band_map(field_of(mesh)), expected);
}

TEST(ConvertInvariants, UnindexedSoupGivesTheSameField) {
    const Mesh mesh = dyadic_torus();
    Mesh soup;
    for (const std::array<int, 3>& triangle : mesh.triangles) {
        const int first = static_cast<int>(soup.vertices_world.size());
        for (const int vertex : triangle)
            soup.vertices_world.push_back(mesh.vertices_world[vertex]);
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    EXPECT_EQ(band_map(field_of(soup)), band_map(field_of(mesh)));
}

TEST(ConvertInvariants, InsideOutMeshGivesTheSameField) {
    const Mesh mesh = dyadic_torus();
    expect_same_band(band_map(field_of(turned_round(mesh))), band_map(field_of(mesh)));
}

TEST(ConvertInvariants, ThreadCountDoesNotMatter) {
    for (const SignMethod sign : {SignMethod::Normal, SignMethod::Winding}) {
        const CheckedMesh mesh = check(sample_mesh("seashell"));
        const ConvertOptions options{.voxel_size_world = 0.03, .sign = sign};
        const auto with_threads = [&](std::size_t threads) {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            return convert(mesh, options);
        };
        const ConvertResult one = with_threads(1);
        const ConvertResult four = with_threads(4);
        EXPECT_EQ(one.distance_evaluations, four.distance_evaluations);
        ASSERT_EQ(one.field.blocks().size(), four.field.blocks().size());
        for (std::size_t i = 0; i < one.field.blocks().size(); ++i) {
            EXPECT_EQ(one.field.blocks()[i].coordinate, four.field.blocks()[i].coordinate);
            EXPECT_EQ(one.field.blocks()[i].active, four.field.blocks()[i].active);
            EXPECT_EQ(one.field.blocks()[i].values, four.field.blocks()[i].values);
        }
    }
}

TEST(ConvertInvariants, WindingNumberGivesTheSignsOfPseudonormals) {
    const CheckedMesh mesh = check(sample_mesh("knot"));
    const auto with = [&](SignMethod sign) {
        return band_map(convert(mesh, {.voxel_size_world = 0.05, .sign = sign}).field);
    };
    EXPECT_EQ(with(SignMethod::Normal), with(SignMethod::Winding));
}

/// A sphere whose vertices are drawn out at random: star-shaped, so closed and free of
/// self-intersections, and closest features are vertices and edges more often than not.
Mesh spiky_solid(unsigned seed) {
    Mesh mesh;
    mesh.vertices_world = {Vec3d::UnitX(),  -Vec3d::UnitX(), Vec3d::UnitY(),
                           -Vec3d::UnitY(), Vec3d::UnitZ(),  -Vec3d::UnitZ()};
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                      {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
        const int middle = static_cast<int>(mesh.vertices_world.size());
        mesh.vertices_world.push_back(
            (mesh.vertices_world[a] + mesh.vertices_world[b] + mesh.vertices_world[c])
                .normalized());
        finer.insert(finer.end(), {{a, b, middle}, {b, c, middle}, {c, a, middle}});
    }
    mesh.triangles = finer;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> radius(0.2, 1.5);
    for (Vec3d& p : mesh.vertices_world) p *= radius(random);
    return mesh;
}

TEST(ConvertInvariants, SpikySolidsHaveNoWrongSign) {
    for (unsigned seed = 0; seed < 40; ++seed) {
        const CheckedMesh mesh = check(spiky_solid(seed));
        const SparseField field =
            convert(mesh, {.voxel_size_world = 0.1, .half_width_voxels = 5}).field;
        const Comparison comparison = compare(field, [&](const Vec3d& p) {
            const double distance = brute_force_distance(mesh.mesh, p);
            return brute_force_winding_number(mesh.mesh, p) > 0.5 ? -distance : distance;
        });
        SCOPED_TRACE(seed);
        expect_exact(comparison);
    }
}

} // namespace
} // namespace isocast::test
