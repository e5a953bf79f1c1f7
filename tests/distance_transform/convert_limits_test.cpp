// Meshes smaller than a voxel and larger than the grid, options that cannot be used, interruption.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/brute_force.h"
#include "distance_transform/sample_meshes.h"
#include "fields.h"
#include "volume/errors.h"

#include "../volume/temporary_folder.h"

#include <chrono>

namespace isocast::test {
namespace {

using ::testing::HasSubstr;

Mesh tetrahedron(double size, const Vec3d& centre) {
    Mesh mesh;
    for (const Vec3d& corner :
         {Vec3d(1, 1, 1), Vec3d(1, -1, -1), Vec3d(-1, 1, -1), Vec3d(-1, -1, 1)})
        mesh.vertices_world.push_back(centre + size * corner);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
    return mesh;
}

/// The box [-half, half]^3.
Mesh cube(double half) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices_world.emplace_back(i & 1 ? half : -half, i & 2 ? half : -half,
                                         i & 4 ? half : -half);
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

double distance_to_cube(const Vec3d& p, double half) {
    const Vec3d q = p.cwiseAbs() - Vec3d::Constant(half);
    return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
}

TEST(ConvertLimits, MeshSmallerThanAVoxelAgreesWithBruteForce) {
    // Beside the samples, and around the sample at the origin, which alone is inside.
    for (const Vec3d& centre : {Vec3d(0.3, 0.2, 0.4), Vec3d(0, 0, 0)}) {
        const CheckedMesh mesh = check(tetrahedron(0.05, centre));
        ASSERT_FALSE(mesh.verdict.reversed);
        const SparseField field = convert(mesh, {.voxel_size_world = 1}).field;
        expect_exact(compare(field, [&](const Vec3d& p) {
            const double distance = brute_force_distance(mesh.mesh, p);
            return brute_force_winding_number(mesh.mesh, p) > 0.5 ? -distance : distance;
        }));
        // A ball of radius 3 holds 4.19 * 27 = 113 unit cells, give or take its surface.
        EXPECT_NEAR(static_cast<double>(field.active_voxel_count()), 113, 20);
        EXPECT_EQ(sample(field, Index3::Zero()) < 0, centre.isZero());
    }
}

TEST(ConvertLimits, LargeTrianglesGiveTheExactDistanceToACube) {
    // 10 * 0.1 is not exact in binary: faces lie on lattice planes only up to rounding, and so does
    // the band's border; the whole layer at 1, 2, 3 voxels must be there all the same.
    for (const double voxel : {1.0, 0.1, 1.0 / 3}) {
        for (const double half_width : {1.0, 3.0, 7.5}) {
            const double half = 40 * voxel;
            const SparseField field = convert(check(cube(half)), {.voxel_size_world = voxel,
                                                                  .half_width_voxels = half_width})
                                          .field;
            expect_exact(compare(field, [&](const Vec3d& p) { return distance_to_cube(p, half); }));
            const IndexBox line{Index3(-60, 0, 0), Index3(60, 1, 1)};
            std::vector<float> values(120);
            field.copy_box(line, 0, values);
            for (int i = 0; i < 120; ++i) {
                const double exact = distance_to_cube({voxel * (i - 60), 0, 0}, half);
                const double reach = half_width * voxel;
                ASSERT_NEAR(values[i], std::clamp(exact, -reach, reach), 1e-6 * voxel * half_width);
            }
        }
    }
}

TEST(ConvertLimits, WideBandAroundAFewTrianglesIsExact) {
    const CheckedMesh mesh = check(cube(1));
    const SparseField field =
        convert(mesh, {.voxel_size_world = 0.25, .half_width_voxels = 30}).field;
    expect_exact(compare(field, [](const Vec3d& p) { return distance_to_cube(p, 1); }));
}

TEST(ConvertLimits, TetrahedraThatShareAVertexKeepTheirSigns) {
    Mesh mesh = tetrahedron(1, Vec3d(1, 1, 1));
    const Mesh other = tetrahedron(-1, Vec3d(3, 3, 3));
    const int first = static_cast<int>(mesh.vertices_world.size());
    mesh.vertices_world.insert(mesh.vertices_world.end(), other.vertices_world.begin(),
                               other.vertices_world.end());
    for (const auto& [a, b, c] : other.triangles)
        mesh.triangles.push_back({a + first, c + first, b + first});
    const CheckedMesh checked = check(mesh);
    ASSERT_EQ(checked.verdict.summary(), "closed, oriented, 1 non-manifold vertex");
    const SparseField field = convert(checked, {.voxel_size_world = 0.083}).field;
    expect_exact(compare(field, [&](const Vec3d& p) {
        const double distance = brute_force_distance(checked.mesh, p);
        return brute_force_winding_number(checked.mesh, p) > 0.5 ? -distance : distance;
    }));
}

TEST(ConvertLimits, FewDistancesAreEvaluated) {
    // Triangles of 0.4 square voxels. Every triangle of the band's reach would be hundreds.
    const ConvertResult result = convert_at(check(sample_mesh("sphere6")), 256);
    EXPECT_LT(static_cast<double>(result.distance_evaluations),
              16.0 * static_cast<double>(result.field.active_voxel_count()));
}

TEST(ConvertLimits, UnusableOptionsAreNamed) {
    const CheckedMesh mesh = check(cube(1));
    const auto message = [&](const ConvertOptions& options) {
        return message_of<InputError>([&] { convert(mesh, options); });
    };
    EXPECT_THAT(message({.voxel_size_world = 0}), HasSubstr("voxel size 0"));
    EXPECT_THAT(message({.voxel_size_world = -1}), HasSubstr("voxel size -1"));
    EXPECT_THAT(message({.voxel_size_world = NAN}), HasSubstr("voxel size nan"));
    EXPECT_THAT(message({.voxel_size_world = 1, .half_width_voxels = 0.5}),
                HasSubstr("half width 0.5"));
    EXPECT_THAT(message({.voxel_size_world = 1, .half_width_voxels = INFINITY}),
                HasSubstr("half width inf"));
    EXPECT_THAT(message_of<InputError>([] { sign_method_from_name("majic"); }),
                HasSubstr("auto, normal, winding"));
    EXPECT_THAT(message_of<InputError>([&] { voxel_size_for_resolution({}, 0); }),
                HasSubstr("resolution 0"));
    EXPECT_THAT(message_of<InputError>([&] {
                    voxel_size_for_resolution({Vec3d::Zero(), Vec3d::Zero()}, 10);
                }),
                HasSubstr("no size"));
    Mesh far = cube(1);
    for (Vec3d& p : far.vertices_world) p.x() += 0x1p40;
    EXPECT_THAT(message_of<InputError>([&] { convert(check(far), {.voxel_size_world = 0x1p-14}); }),
                HasSubstr("double precision"));
}

TEST(ConvertLimits, SignMethodsKeepTheirNames) {
    for (const SignMethod method :
         {SignMethod::Auto, SignMethod::Normal, SignMethod::Winding, SignMethod::Unsigned})
        EXPECT_EQ(sign_method_from_name(name_of(method)), method);
}

TEST(ConvertLimits, FieldsLargerThanMemoryAreRefusedAtOnce) {
    const CheckedMesh mesh = check(sample_mesh("sphere6"));
    const auto start = std::chrono::steady_clock::now();
    const auto message = [&](const ConvertOptions& options) {
        return message_of<ResourceError>([&] { convert(mesh, options); });
    };
    EXPECT_THAT(message({.voxel_size_world = 2e-6}), HasSubstr("GiB of memory may be taken"));
    EXPECT_THAT(message({.voxel_size_world = 1e-3, .half_width_voxels = 1e5}),
                HasSubstr("GiB of memory may be taken"));
    EXPECT_THAT(message({.voxel_size_world = 1e-9}), HasSubstr("would span"));
    EXPECT_THAT(message({.voxel_size_world = 1, .half_width_voxels = 1e30}),
                HasSubstr("would span"));
    // Far less than any of these would take; the estimates need milliseconds.
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
}

TEST(ConvertLimits, InterruptionInAnyStageEndsTheWork) {
    Mesh mesh = sample_mesh("sphere6");
    mesh.triangles.resize(mesh.triangles.size() - 9); // open, so that the signs' stage comes too
    const CheckedMesh checked = check(mesh);
    for (const std::string_view wanted : {"prepare", "transform", "signs"}) {
        std::atomic<bool> was_thrown = false;
        const Progress progress = [&](std::string_view stage, double fraction) {
            ASSERT_GE(fraction, 0);
            ASSERT_LE(fraction, 1);
            if (stage == wanted && fraction > 0) {
                was_thrown = true;
                throw Interrupted();
            }
        };
        EXPECT_THROW(convert(checked, {.voxel_size_world = 0.02}, progress), Interrupted);
        EXPECT_TRUE(was_thrown) << wanted;
    }
}

TEST(ConvertLimits, ProgressIsReportedOften) {
    std::atomic<int> calls = 0;
    const CheckedMesh mesh = check(sample_mesh("sphere6"));
    const auto start = std::chrono::steady_clock::now();
    convert(mesh, {.voxel_size_world = 0.01}, [&](std::string_view, double) { ++calls; });
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_GT(calls, 10 * seconds); // several times a second with a margin
}

} // namespace
} // namespace isocast::test
