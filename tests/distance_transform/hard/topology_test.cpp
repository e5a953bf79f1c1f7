// Fans, saddles, spikes, several shells, surfaces that touch or cross themselves or have one side.
// SPDX-License-Identifier: MPL-2.0
#include "exact_field.h"

namespace isocast::test {
namespace {

using std::numbers::pi;

// The closest triangle of a point lies in its own sector or beside it, since the solid is convex
// and has that symmetry: brute force over all 200,000 would take minutes.
TEST(HardMeshes, FanOfHundredThousandTrianglesIsExact) {
    constexpr int sides = 100000;
    std::vector<Vec3d> rim;
    for (int i = 0; i < sides; ++i)
        rim.emplace_back(std::cos(2 * pi * i / sides), std::sin(2 * pi * i / sides), 0);
    const Mesh mesh = double_cone(rim, Vec3d(0, 0, 0.8), Vec3d(0, 0, -0.5));
    const CheckedMesh checked = check(mesh);
    for (const double half_width : {3.0, 8.0}) {
        SCOPED_TRACE(half_width);
        const SparseField field =
            convert(checked, {.voxel_size_world = 0.17, .half_width_voxels = half_width}).field;
        const IndexBox around = box_about(mesh, field.space(), half_width);
        const Mesh near = in_voxels(mesh, field.space(), around.lo);
        const Vec3d middle =
            in_voxels({{Vec3d::Zero()}, {}}, field.space(), around.lo).vertices_world[0];
        const auto sector = [&](const Vec3d& p) {
            const double turn = std::atan2(p.y() - middle.y(), p.x() - middle.x()) / (2 * pi);
            const int first = static_cast<int>(std::floor((turn + 1) * sides));
            std::vector<Triangle> few;
            for (int i = first - 2; i <= first + 2; ++i)
                for (const int half : {0, 1}) few.push_back(near.triangles[2 * (i % sides) + half]);
            return few;
        };
        const KnownField known =
            known_field({.distance_near =
                             [&](const Vec3d&, double) {
                                 return [&](const Vec3d& p) {
                                     Mesh few;
                                     for (const Triangle& triangle : sector(p)) {
                                         const int at = static_cast<int>(few.vertices_world.size());
                                         for (const int v : triangle)
                                             few.vertices_world.push_back(near.vertices_world[v]);
                                         few.triangles.push_back({at, at + 1, at + 2});
                                     }
                                     return brute_force_distance(few, p);
                                 };
                             },
                         .winding =
                             [&](const Vec3d& p) {
                                 // Convex: inside is what is below the planes of all of its sector.
                                 bool is_inside = true;
                                 for (const auto& [a, b, c] : sector(p)) {
                                     const Vec3d& from = near.vertices_world[a];
                                     is_inside =
                                         is_inside && (near.vertices_world[b] - from)
                                                              .cross(near.vertices_world[c] - from)
                                                              .dot(p - from) < 0;
                                 }
                                 return is_inside ? 1.0 : 0.0;
                             }},
                        around, half_width);
        expect_no_faults(faults_of(field, known, half_width));
    }
}

// Alternately up and down round the apex, from near flat to steep.
TEST(HardMeshes, SaddlesOfAnyValenceAreExact) {
    for (const int valence : {3, 4, 5, 6, 7, 8, 12, 17, 32, 64})
        for (const double swing : {0.05, 0.6}) {
            SCOPED_TRACE(valence);
            std::vector<Vec3d> rim;
            for (int i = 0; i < valence; ++i)
                rim.emplace_back(std::cos(2 * pi * i / valence), std::sin(2 * pi * i / valence),
                                 i % 2 == 0 ? swing : -swing);
            expect_exact_conversion(
                tilted(double_cone(rim, Vec3d(0.01, 0.02, 0), Vec3d(0, 0, -1.1))), 0.17);
        }
}

TEST(HardMeshes, WedgeOfAHundredthOfADegreeIsExact) {
    const double thickness = std::tan(0.01 * pi / 180);
    Mesh mesh = box(Vec3d(0, -0.5, 0), Vec3d(1, 0.5, 1));
    for (Vec3d& p : mesh.vertices_world) p.z() *= (1 - p.x()) * thickness;
    // At x = 1 the two layers of corners are one.
    expect_exact_conversion(tilted(mesh), 0.037);
    expect_exact_conversion(moved(mesh, Vec3d(0.01, 0, 0)), 0.037);
}

TEST(HardMeshes, NeedleOfAHundredthOfADegreeOnASphereIsExact) {
    expect_exact_conversion(tilted(needle_on_a_ball()), 0.11);
}

TEST(HardMeshes, ShellsCloserThanAVoxelAreExact) {
    for (const double gap : {0.3, 0.01, 1e-6}) {
        SCOPED_TRACE(gap);
        const double voxel = 0.11;
        const Mesh first = tilted(subdivided(cube(), 1));
        const Mesh second = tilted(moved(subdivided(cube(), 1), Vec3d(2 + gap * voxel, 0.3, 0.2)));
        expect_exact_conversion(joined(first, second), voxel);
    }
}

// The gap is some voxels wide, and less than one.
TEST(HardMeshes, ShellWithinAShellOfTheSameOrientationIsSolid) {
    for (const double size : {0.5, 0.85}) {
        SCOPED_TRACE(size);
        const Mesh outer = sphere(2);
        const ConvertResult result =
            expect_exact_conversion(joined(outer, scaled(tilted(outer), size)), 0.2);
        EXPECT_LT(sample(result.field, Index3::Zero()), 0);
    }
}

TEST(HardMeshes, ReversedShellWithinAShellIsACavity) {
    for (const double size : {0.5, 0.85}) {
        SCOPED_TRACE(size);
        const Mesh outer = sphere(2);
        const ConvertResult result =
            expect_exact_conversion(joined(outer, turned_round(scaled(outer, size))), 0.2);
        EXPECT_GT(sample(result.field, Index3::Zero()), 0);
    }
}

TEST(HardMeshes, ThreeShellsWithinEachOtherAreExact) {
    const Mesh outer = sphere(2);
    expect_exact_conversion(
        joined(joined(outer, turned_round(scaled(outer, 0.7))), scaled(outer, 0.4)), 0.11);
}

TEST(HardMeshes, OverlappingShellsAreTheirUnion) {
    expect_exact_conversion(joined(sphere(3), tilted(moved(sphere(3), Vec3d(0.9, 0.2, 0.4)))),
                            0.11);
    expect_exact_conversion(joined(cube(), tilted(moved(cube(), Vec3d(1.1, 0.7, 0.4)))), 0.11);
}

// The overlap is thinner than the voxels: hardly a sample lies in it.
TEST(HardMeshes, ShellsThatOverlapByLessThanAVoxelAreTheirUnion) {
    const Mesh first = tilted(subdivided(cube(), 1));
    const Mesh second = tilted(moved(subdivided(cube(), 1), Vec3d(1.97, 0.3, 0.2)));
    expect_exact_conversion(joined(first, second), 0.11);
}

// A tube along a figure of eight goes through itself: winding number 2 where it does.
TEST(HardMeshes, ShellThatPiercesItselfIsWhereTheWindingNumberIsAboveAHalf) {
    expect_exact_conversion(crossing_tube(48, 8), 0.07);
}

// A vertex pushed through the other side: winding number 0 in the dent and -1 beyond it.
TEST(HardMeshes, DentThatLeavesTheOtherSideIsOutside) {
    Mesh mesh = tilted(sphere(2));
    mesh.vertices_world[4] *= -1.7;
    expect_exact_conversion(mesh, 0.09);
}

TEST(HardMeshes, CubesThatShareAnEdgeAreExact) {
    const Mesh mesh = joined(cube(), moved(cube(), Vec3d(2, 2, 0)));
    ASSERT_EQ(check(mesh).verdict.non_manifold_edges, 1);
    expect_exact_conversion(mesh, 0.13);
    expect_exact_conversion(rounded(tilted(mesh)), 0.13);
}

TEST(HardMeshes, CubesThatShareAFaceAreTheirUnion) {
    expect_exact_conversion(joined(cube(), moved(cube(), Vec3d(2, 0, 0))), 0.13);
}

TEST(HardMeshes, TetrahedraTipToTipAreExact) {
    const Mesh one = tetrahedron();
    const Mesh mesh =
        joined(moved(one, -Vec3d::Ones()), turned_round(moved(scaled(one, -1), Vec3d::Ones())));
    ASSERT_EQ(check(mesh).verdict.non_manifold_vertices, 1);
    expect_exact_conversion(mesh, 0.13);
    expect_exact_conversion(rounded(tilted(mesh)), 0.13);
}

TEST(HardMeshes, MoebiusStripHasExactDistancesAndAWarningOfItsSigns) {
    const Mesh mesh = moebius_strip(60);
    const ConvertResult result = expect_exact_conversion(mesh, 0.06, mesh, Sides::None);
    EXPECT_EQ(result.sign_used, SignMethod::Unsigned);
    EXPECT_EQ(result.field.outside(), Outside::Background);
    EXPECT_THAT(result.warnings, ::testing::Contains(::testing::HasSubstr("one side only")));
}

} // namespace
} // namespace isocast::test
