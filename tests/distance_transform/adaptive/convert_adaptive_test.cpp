// From mesh to adaptive field: invariances, verdicts of imperfect meshes, limits.
// SPDX-License-Identifier: MPL-2.0
#include "adaptive_fields.h"
#include "distance_transform/convert_adaptive.h"
#include "volume/errors.h"

namespace isocast::test {
namespace {

using ::testing::HasSubstr;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Corners at multiples of 2^-24 world, so that adding small whole numbers rounds nothing.
CheckedMesh rounded_knot(double scale, const Vec3d& offset) {
    Mesh mesh = sample_mesh("knot");
    for (Vec3d& p : mesh.vertices_world)
        p = (scale * ((p * 0x1p24).array().round() * 0x1p-24).matrix() + offset).eval();
    return check(mesh);
}

const AdaptiveConvertOptions cells_of_a_32nd{.max_error_world = 0x1p-5, .voxel_size_world = 0x1p-5};

TEST(ConvertAdaptive, MovedByWholeCellsIsTheSameTreeMoved) {
    const Vec3d offset = 0x1p-5 * Vec3d(7, -16, 129);
    const AdaptiveConvertResult a =
        convert_adaptive(rounded_knot(1, Vec3d::Zero()), cells_of_a_32nd);
    const AdaptiveConvertResult b = convert_adaptive(rounded_knot(1, offset), cells_of_a_32nd);
    EXPECT_TRUE(TreeContent(a.tree) == TreeContent(b.tree));
    EXPECT_EQ(a.space.to_world(Vec3d::Zero()) + offset, b.space.to_world(Vec3d::Zero()));
}

TEST(ConvertAdaptive, ScaledByAPowerOfTwoIsTheSameTreeWithScaledValues) {
    AdaptiveConvertOptions options = cells_of_a_32nd;
    const AdaptiveConvertResult a = convert_adaptive(rounded_knot(1, Vec3d::Zero()), options);
    for (const double scale : {0x1p-40, 0x1p60}) {
        options.max_error_world = scale * 0x1p-5;
        options.voxel_size_world = scale * 0x1p-5;
        const AdaptiveConvertResult b =
            convert_adaptive(rounded_knot(scale, Vec3d::Zero()), options);
        const TreeContent ours(a.tree);
        const TreeContent theirs(b.tree);
        EXPECT_TRUE(ours.cells == theirs.cells);
        ASSERT_EQ(ours.data.size(), theirs.data.size());
        for (std::size_t i = 0; i < ours.data.size(); ++i)
            ASSERT_EQ(scale * ours.data[i], theirs.data[i]);
    }
}

TEST(ConvertAdaptive, HoldsTheMeshWithinTheRootAndItsErrorInWorldUnits) {
    for (const OctreeFilter filter : octree_filters) {
        const CheckedMesh mesh = check(sample_mesh("knot"));
        const double max_error = 0.004 * bounding_box(mesh.mesh).size().maxCoeff();
        const AdaptiveConvertResult result =
            convert_adaptive(mesh, {.max_error_world = max_error, .filter = filter});
        // The largest cells that keep the error by Lipschitz's bound, half their diagonal.
        EXPECT_NEAR(result.space.voxel_size_world() * std::numbers::sqrt3 / 2, max_error,
                    1e-12 * max_error);
        Random random(1);
        for (const Vec3d& p : points_of_surface(mesh.mesh, 20'000, random)) {
            const Vec3d p_index = result.space.to_index(p);
            ASSERT_GE(p_index.minCoeff(), 1);
            ASSERT_LE(p_index.maxCoeff(), result.tree.root().size() - 1);
            // 1e-5: roundings of floats as large as the root, some 300 errors.
            ASSERT_LE(std::abs(result.tree.value_at(p_index)), (1 + 1e-4) * max_error);
        }
    }
}

TEST(ConvertAdaptive, InsideOutIsTurnedRound) {
    Mesh mesh = sample_mesh("torus");
    for (auto& [a, b, c] : mesh.triangles) std::swap(b, c);
    const CheckedMesh turned = check(mesh);
    EXPECT_TRUE(turned.verdict.reversed);
    const AdaptiveConvertResult result = convert_adaptive(turned, cells_of_a_32nd);
    EXPECT_EQ(result.sign_used, SignMethod::Normal);
    const AdaptiveConvertResult right =
        convert_adaptive(check(sample_mesh("torus")), cells_of_a_32nd);
    Random random(2);
    // The same field; corners in another order round otherwise.
    for (int i = 0; i < 10'000; ++i) {
        const Vec3d p = random_point(random, 0, right.tree.root().size());
        ASSERT_NEAR(result.tree.value_at(p), right.tree.value_at(p), 1e-5);
    }
}

TEST(ConvertAdaptive, OpenMeshHasTheSignsOfItsWindingNumber) {
    Mesh mesh = sample_mesh("sphere6");
    std::erase_if(mesh.triangles, [&](const std::array<int, 3>& triangle) {
        return mesh.vertices_world[triangle[0]].z() > 0.9;
    });
    const AdaptiveConvertResult result = convert_adaptive(check(mesh), cells_of_a_32nd);
    EXPECT_EQ(result.sign_used, SignMethod::Winding);
    ASSERT_EQ(result.warnings.size(), 1u);
    EXPECT_THAT(result.warnings[0], HasSubstr("winding number"));
    EXPECT_LT(result.tree.value_at(result.space.to_index(Vec3d::Zero())), -0.8);
    EXPECT_GT(result.tree.value_at(result.space.to_index(Vec3d(0, 0, -1.05))), 0);
}

TEST(ConvertAdaptive, MoebiusStripIsRefusedForItHasNoInside) {
    Mesh strip;
    constexpr int count = 24;
    for (int i = 0; i < count; ++i) {
        const double angle = i * 2 * std::numbers::pi / count;
        const Vec3d outwards(std::cos(angle), std::sin(angle), 0);
        const Vec3d across =
            0.3 * (std::cos(angle / 2) * outwards + std::sin(angle / 2) * Vec3d::UnitZ());
        strip.vertices_world.push_back(outwards + across);
        strip.vertices_world.push_back(outwards - across);
    }
    for (int i = 0; i < count; ++i) {
        // After a round upper and lower ends have changed places.
        const bool is_last = i + 1 == count;
        const int a = 2 * i;
        const int b = 2 * i + 1;
        const int c = is_last ? 1 : 2 * i + 2;
        const int d = is_last ? 0 : 2 * i + 3;
        strip.triangles.push_back({a, b, c});
        strip.triangles.push_back({b, d, c});
    }
    const CheckedMesh mesh = check(strip);
    ASSERT_FALSE(mesh.verdict.is_orientable);
    EXPECT_THAT([&] { convert_adaptive(mesh, cells_of_a_32nd); },
                ::testing::ThrowsMessage<InputError>(HasSubstr("not orientable")));
    EXPECT_THAT(
        [&] {
            AdaptiveConvertOptions options = cells_of_a_32nd;
            options.sign = SignMethod::Unsigned;
            convert_adaptive(check(sample_mesh("knot")), options);
        },
        ::testing::ThrowsMessage<InputError>(HasSubstr("needs signs")));
}

TEST(ConvertAdaptive, UnusableOptionsAreRefused) {
    const CheckedMesh mesh = check(sample_mesh("torus"));
    for (const double bad : {0.0, -1.0, std::nan(""), infinity}) {
        EXPECT_THROW(convert_adaptive(mesh, {.max_error_world = bad}), InputError) << bad;
        EXPECT_THROW(convert_adaptive(mesh, {.voxel_size_world = bad}), InputError) << bad;
    }
    for (const double bad : {-1.0, std::nan(""), infinity})
        EXPECT_THROW(convert_adaptive(mesh, {.max_error_world = 0.1, .accurate_within_world = bad}),
                     InputError)
            << bad;
    EXPECT_THROW(convert_adaptive(mesh, {}), InputError);
    // Deeper than a tree can be.
    EXPECT_THROW(convert_adaptive(mesh, {.max_error_world = 1e-30}), ResourceError);
    EXPECT_THROW(convert_adaptive(mesh, {.max_error_world = 5e-324}), ResourceError);
    EXPECT_THROW(convert_adaptive(mesh, {.voxel_size_world = 1e-7}), ResourceError);
}

// All of it errs by less than that.
TEST(ConvertAdaptive, AnErrorFarLargerThanTheMeshGivesASmallTree) {
    const CheckedMesh mesh = check(sample_mesh("torus"));
    for (const double max_error : {1e3, 1e30}) {
        const AdaptiveConvertResult result = convert_adaptive(mesh, {.max_error_world = max_error});
        EXPECT_LE(result.tree.depth(), 3);
        for (const Vec3d& p : mesh.mesh.vertices_world)
            EXPECT_LE(std::abs(result.tree.value_at(result.space.to_index(p))), max_error);
    }
}

TEST(ConvertAdaptive, MemoryIsHeeded) {
    const CheckedMesh mesh = check(sample_mesh("torus"));
    AdaptiveConvertOptions options = cells_of_a_32nd;
    options.sign = SignMethod::Normal; // so that no band is made, which takes memory too
    const auto needed = static_cast<double>(convert_adaptive(mesh, options).tree.memory_bytes());
    options.memory_bytes = 0.5 * needed;
    EXPECT_THAT([&] { convert_adaptive(mesh, options); },
                ::testing::ThrowsMessage<ResourceError>(HasSubstr("memory")));
    options.memory_bytes = 50 * needed;
    EXPECT_NO_THROW(convert_adaptive(mesh, options));
}

} // namespace
} // namespace isocast::test
