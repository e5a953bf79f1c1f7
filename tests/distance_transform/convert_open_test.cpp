// Meshes that are not closed: signs by winding number, also where no block is stored.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/brute_force.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "distance_transform/winding_number.h"
#include "fields.h"

#include <random>

namespace isocast::test {
namespace {

/// Unit sphere without the part above z = `height`: a hole many blocks wide at fine voxels.
Mesh open_sphere(double height) {
    Mesh mesh = sample_mesh("sphere6");
    std::erase_if(mesh.triangles, [&](const std::array<int, 3>& triangle) {
        return mesh.vertices_world[triangle[0]].z() > height;
    });
    return mesh;
}

/// Samples of the extent, dilated so that rows beyond the blocks are seen too.
struct DenseSamples {
    IndexBox box;
    std::vector<float> values;

    explicit DenseSamples(const SparseField& field) : box(dilated(field.extent(), 20, 20)) {
        values.resize(static_cast<std::size_t>(box.sample_count()));
        field.copy_box(box, 0, values);
    }
    Index3 index(std::size_t i) const {
        const auto at = static_cast<int>(i);
        const Index3 size = box.size();
        return box.lo + Index3(at % size.x(), at / size.x() % size.y(), at / (size.x() * size.y()));
    }
};

/// Signs of all samples, band or not, against the exact winding number wherever that is not close
/// to 1/2: the hierarchy's error is below the margin (WindingNumber tests).
void expect_signs_of_winding_number(const CheckedMesh& mesh, const SparseField& field, int count) {
    const DenseSamples samples(field);
    std::mt19937 random(3);
    std::uniform_int_distribution<std::size_t> any(0, samples.values.size() - 1);
    std::vector<std::size_t> chosen(count);
    for (std::size_t& i : chosen) i = any(random);
    std::atomic<int> wrong = 0;
    std::atomic<int> inside = 0;
    tbb::parallel_for(std::size_t{0}, chosen.size(), [&](std::size_t k) {
        const Index3 index = samples.index(chosen[k]);
        const double w =
            brute_force_winding_number(mesh.mesh, field.space().to_world(index.cast<double>()));
        // Between samples of the lattice the surface w = 1/2 is where a block of 8 decides.
        if (std::abs(w - 0.5) < 0.1) return;
        if ((samples.values[chosen[k]] < 0) != (w > 0.5)) ++wrong;
        if (w > 0.5) ++inside;
    });
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(inside, 0);
}

TEST(ConvertOpen, AutoChoosesTheWindingNumberAndSaysSo) {
    const ConvertResult result = convert(check(open_sphere(0.9)), {.voxel_size_world = 0.1});
    EXPECT_EQ(result.sign_used, SignMethod::Winding);
    ASSERT_EQ(result.warnings.size(), 1u);
    EXPECT_THAT(result.warnings[0], ::testing::HasSubstr("winding number"));
    EXPECT_TRUE(convert(check(sample_mesh("knot")), {.voxel_size_world = 0.2}).warnings.empty());
}

TEST(ConvertOpen, SphereWithAHoleKeepsItsInside) {
    for (const double height : {0.95, 0.6}) {
        const CheckedMesh mesh = check(open_sphere(height));
        const SparseField field = convert(mesh, {.voxel_size_world = 0.02}).field;
        expect_signs_of_winding_number(mesh, field, 400);
        EXPECT_LT(sample(field, Index3::Zero()), 0);
    }
}

TEST(ConvertOpen, DistancesAreExactWhateverTheSign) {
    const CheckedMesh mesh = check(open_sphere(0.6));
    const SparseField field = convert(mesh, {.voxel_size_world = 0.05}).field;
    const Comparison comparison =
        compare(field, [&](const Vec3d& p) { return brute_force_distance(mesh.mesh, p); });
    EXPECT_GT(comparison.samples, 0);
    EXPECT_LT(comparison.worst_error_voxels, 1e-5); // as fields.h says
}

TEST(ConvertOpen, SingleTriangleHasNoInside) {
    Mesh mesh;
    mesh.vertices_world = {Vec3d(-100, -100, 0.3), Vec3d(100, -90, 0.3), Vec3d(0, 110, 0.4)};
    mesh.triangles = {{0, 1, 2}};
    const SparseField field = convert(check(mesh), {.voxel_size_world = 1}).field;
    const DenseSamples samples(field);
    EXPECT_TRUE(std::ranges::all_of(samples.values, [](float value) { return value > 0; }));
    EXPECT_GT(field.active_voxel_count(), 100000); // 20,000 square voxels, six layers
}

TEST(ConvertOpen, BunnyWithHolesIsWhole) {
    const auto open_file = shared_data("stanford-bunny.obj");
    const auto closed_file = shared_data("bunny-closed.obj");
    if (!std::filesystem::exists(open_file) || !std::filesystem::exists(closed_file))
        GTEST_SKIP() << "the bunnies are not there";
    const CheckedMesh open = check(read_mesh(open_file));
    const CheckedMesh closed = check(read_mesh(closed_file));
    const double voxel = voxel_size_for_resolution(bounding_box(open.mesh), 128);
    const SparseField field = convert(open, {.voxel_size_world = voxel}).field;
    const SparseField truth = convert(closed, {.voxel_size_world = voxel}).field;
    expect_signs_of_winding_number(open, field, 400);

    // The filled holes are flat patches: signs differ only near them, where the winding number
    // draws another surface over the hole.
    const DenseSamples samples(field);
    std::vector<float> expected(samples.values.size());
    truth.copy_box(samples.box, 0, expected);
    int differing = 0;
    int far_from_surface = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if ((samples.values[i] < 0) == (expected[i] < 0)) continue;
        ++differing;
        if (std::abs(expected[i]) == static_cast<float>(truth.background_world()))
            ++far_from_surface;
    }
    // A streak would be a row of dozens of samples: all differences lie within the closed bunny's
    // band, in the two holes of the base (the largest is 12 voxels wide).
    EXPECT_LT(differing, 200);
    EXPECT_EQ(far_from_surface, 0);
}

/// `mesh` and a copy moved along x, whose triangles are turned round if asked.
Mesh doubled(const Mesh& mesh, double distance, bool turn) {
    Mesh result = mesh;
    const int first = static_cast<int>(mesh.vertices_world.size());
    for (const Vec3d& p : mesh.vertices_world)
        result.vertices_world.emplace_back(p + distance * Vec3d::UnitX());
    for (const auto& [a, b, c] : mesh.triangles)
        result.triangles.push_back(turn ? std::array{a + first, c + first, b + first}
                                        : std::array{a + first, b + first, c + first});
    return result;
}

// Closed and oriented, but normals contradict each other where one sphere is inside the other.
TEST(ConvertOpen, OverlappingSpheresAreTheirUnion) {
    const CheckedMesh mesh = check(doubled(sample_mesh("sphere6"), 1.013, false));
    ASSERT_EQ(mesh.verdict.summary(), "closed, oriented, manifold");
    const ConvertResult result = convert(mesh, {.voxel_size_world = 0.05});
    EXPECT_EQ(result.sign_used, SignMethod::Winding);
    expect_signs_of_winding_number(mesh, result.field, 400);
}

TEST(ConvertOpen, ShellThatIsInsideOutDrawsNoStreak) {
    const CheckedMesh mesh = check(doubled(sample_mesh("torus"), 4, true));
    ASSERT_TRUE(mesh.verdict.is_closed() && mesh.verdict.is_oriented());
    const ConvertResult result = convert(mesh, {.voxel_size_world = 0.05});
    EXPECT_EQ(result.sign_used, SignMethod::Winding);
    expect_signs_of_winding_number(mesh, result.field, 400);
}

TEST(ConvertOpen, SoupOfFlippedAndNonManifoldTrianglesIsConverted) {
    if (!std::filesystem::exists(shared_data("truck.obj"))) GTEST_SKIP() << "no truck.obj";
    const CheckedMesh mesh = check(read_mesh(shared_data("truck.obj")));
    const SparseField field = convert_at(mesh, 64).field;
    const Comparison comparison =
        compare(field, [&](const Vec3d& p) { return brute_force_distance(mesh.mesh, p); });
    EXPECT_LT(comparison.worst_error_voxels, 1e-5); // as fields.h says
}

} // namespace
} // namespace isocast::test
