// Far from the origin, very large and very small: the truth is the field of the rounded vertices.
// SPDX-License-Identifier: MPL-2.0
#include "exact_field.h"
#include "volume/errors.h"

namespace isocast::test {
namespace {

// Rounding moves vertices by up to 1e-8 of the size, so that triangles are not quite what they
// were.
TEST(HardMeshes, FarFromTheOriginTheRoundedMeshIsExact) {
    for (const double offset : {1e6, 1e8})
        for (const bool is_closed : {true, false}) {
            SCOPED_TRACE(offset);
            Mesh mesh = moved(noisy_sphere(30, 2), Vec3d(2.1, -1.7, 1.9) * offset);
            if (!is_closed) mesh.triangles.resize(115);
            expect_exact_conversion(mesh, 0.11, mesh, is_closed ? Sides::Closed : Sides::Open);
        }
}

TEST(HardMeshes, TinyAndHugeMeshesAreExact) {
    for (const double scale : {1e-12, 1e-6, 1e6, 1e12}) {
        SCOPED_TRACE(scale);
        const ConvertResult result =
            expect_exact_conversion(scaled(noisy_sphere(31, 2), scale), 0.11 * scale);
        EXPECT_EQ(result.sign_used, SignMethod::Normal);
    }
}

// Found by mutation of mesh files: coordinates of 1e303 gave a field of infinities.
TEST(HardMeshes, BandsThatFloat32CannotHoldAreRefused) {
    for (const double scale : {1e-50, 1e40, 1e300}) {
        SCOPED_TRACE(scale);
        const CheckedMesh mesh = check(scaled(tetrahedron(), scale));
        EXPECT_THROW(convert(mesh, {.voxel_size_world = 0.1 * scale}), InputError);
    }
}

TEST(HardMeshes, TrianglesMuchLargerThanTheBandAreExact) {
    for (const Mesh& mesh : {box(Vec3d(-0.013, 0.02, 0.007), Vec3d(1.01, 0.63, 0.41)),
                             tilted(box(Vec3d::Zero(), Vec3d(1.03, 0.71, 0.35)))})
        expect_exact_conversion(mesh, 0.01);
}

TEST(HardMeshes, SingleLargeTriangleIsExactAndHasNoInside) {
    const Mesh mesh = tilted({{Vec3d(0, 0, 0), Vec3d(1, 0.1, 0), Vec3d(0.3, 0.9, 0)}, {{0, 1, 2}}});
    const ConvertResult result = expect_exact_conversion(mesh, 0.01, mesh, Sides::None);
    for (const FieldBlock& block : result.field.blocks())
        // 0 at the corner that is a sample.
        ASSERT_TRUE(std::ranges::all_of(block.values, [](float value) { return value >= 0; }));
}

// A corner and its neighbour 1e-30 away are two points of the world, and one in voxels from the
// middle of the box.
TEST(HardMeshes, VerticesThatRoundingMergesAreExact) {
    Mesh mesh = box(Vec3d::Zero(), Vec3d(9.3, 7.1, 5.2));
    const auto index_of = [&](const Vec3d& p) {
        return static_cast<int>(std::ranges::find(mesh.vertices_world, p) -
                                mesh.vertices_world.begin());
    };
    const int corner = index_of(Vec3d::Zero());
    const int end = index_of(Vec3d(9.3, 0, 0));
    const int added = static_cast<int>(mesh.vertices_world.size());
    mesh.vertices_world.emplace_back(1e-30, 0, 0);
    // Both triangles at that edge are split.
    for (std::size_t t = 0, count = mesh.triangles.size(); t < count; ++t) {
        for (int k = 0; k < 3; ++k) {
            const std::array<int, 3> old = mesh.triangles[t];
            const int a = old[k];
            const int b = old[(k + 1) % 3];
            if (!((a == corner && b == end) || (a == end && b == corner))) continue;
            const int c = old[(k + 2) % 3];
            mesh.triangles[t] = {a, added, c};
            mesh.triangles.push_back({added, b, c});
        }
    }
    ASSERT_EQ(mesh.triangles.size(), 14U);
    ASSERT_TRUE(check(mesh).verdict.is_closed());
    expect_exact_conversion(mesh, 0.7);
}

// Between samples, about one, and with a corner on one.
TEST(HardMeshes, MeshSmallerThanAVoxelIsExact) {
    for (const double size : {0.3, 0.01, 1e-6})
        for (const Vec3d& middle :
             {Vec3d(0.3, 0.2, 0.4), Vec3d(5, -3, 2), Vec3d(Vec3d::Constant(-size))}) {
            SCOPED_TRACE(size);
            const Mesh mesh = moved(scaled(tetrahedron(), size), middle);
            const ConvertResult result = expect_exact_conversion(mesh, 1);
            // The ball of radius 3 holds 113 unit cells, give or take its surface.
            EXPECT_NEAR(double(result.field.active_voxel_count()), 113, size < 0.1 ? 20 : 60);
        }
}

TEST(HardMeshes, ThinPlateIsExact) {
    for (const double thickness : {0.5, 1e-3, 1e-7}) {
        SCOPED_TRACE(thickness);
        expect_exact_conversion(tilted(box(Vec3d::Zero(), Vec3d(20, 15, thickness))), 1);
    }
}

} // namespace
} // namespace isocast::test
