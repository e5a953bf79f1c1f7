// Classification of vertices and complete covering: table 4.1 and appendix A of the thesis.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/prism.h"

#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "fields.h"
#include "meshes.h"
#include "volume/errors.h"

namespace isocast::test {
namespace {

Vec3d apex_of(const Mesh& mesh, int corner) {
    return mesh.vertices_world[mesh.triangles[corner / 3][corner % 3]];
}

/// Of the prisms around a vertex, by their planes through it alone: how many hold apex + y.
int multiplicity(const Mesh& mesh, const Prisms& prisms, std::span<const int> ring,
                 const Vec3d& y) {
    int count = 0;
    for (const int corner : ring) {
        const auto planes = prisms.half_spaces(corner / 3);
        const Vec3d p = apex_of(mesh, corner) + y;
        const auto holds = [&](int halfedge) {
            return planes[halfedge % 3].normal.dot(p) <= planes[halfedge % 3].offset;
        };
        count += holds(corner) && holds(previous_halfedge(corner)) ? 1 : 0;
    }
    return count;
}

/// The edges of the gap's cone, by all pairs of planes instead of neighbouring ones: unit vectors
/// along lines of two planes that are right of all others. Empty if there is no gap.
std::vector<Vec3d> gap_edges(const Prisms& prisms, std::span<const int> ring) {
    std::vector<Vec3d> planes;
    for (const int corner : ring)
        planes.push_back(-prisms.half_spaces(corner / 3)[corner % 3].normal);
    std::vector<Vec3d> edges;
    for (std::size_t i = 0; i < planes.size(); ++i) {
        for (std::size_t j = i + 1; j < planes.size(); ++j) {
            const Vec3d line = planes[i].cross(planes[j]);
            if (line.norm() < 1e-10) continue; // one plane: no line
            int left = 0;
            int right = 0;
            for (std::size_t k = 0; k < planes.size(); ++k) {
                if (k == i || k == j) continue;
                const double side = planes[k].dot(line);
                // 1e-10: planes are that certain (one_rings.cpp); on a plane means covered.
                left += side <= 1e-10 ? 1 : 0;
                right += side >= -1e-10 ? 1 : 0;
            }
            if (left == 0) edges.push_back(line.normalized());
            if (right == 0) edges.push_back(-line.normalized());
        }
    }
    return edges;
}

TEST(Table41, Sphere6IsThePapers) {
    EXPECT_EQ(Prisms(sample_mesh("sphere6"), 1, Gaps::Leave).counts(),
              (CoveringCounts{16386, 0, 0}));
}

TEST(Table41, TorusHasSaddlesWhereItsCurvatureSaysSo) {
    // Circles around the tube bend inward of the axis: of each section's 50 vertices the 24 on the
    // inner side and the 2 on the border are saddles. The quads are plane, so diagonals count for
    // nothing. (The paper's 1788 of 3000 is no multiple of any possible number of sections above
    // gcd(1788, 3000) = 12: there, the rounding of plane quads took part.)
    EXPECT_EQ(Prisms(sample_mesh("torus"), 1, Gaps::Leave).counts(),
              (CoveringCounts{3000, 26 * 60, 0}));
}

TEST(Table41, GapsAreOnlyAtSaddles) {
    for (const char* name : {"knot", "seashell"}) {
        const Mesh mesh = sample_mesh(name);
        const Prisms prisms(mesh, 1, Gaps::Leave);
        EXPECT_EQ(prisms.counts().vertices, static_cast<int>(mesh.vertices_world.size()));
        EXPECT_GT(prisms.counts().gaps, 0) << name;
        for (std::size_t i = 0; i < prisms.rings().count(); ++i) {
            if (prisms.has_gap(i)) {
                EXPECT_EQ(prisms.rings().kind(i), VertexKind::Saddle);
            }
        }
    }
}

TEST(Table41, OpenBunnyIsThePapersAndItsBordersMakeTheRestOfTheGaps) {
    const auto path = shared_data("stanford-bunny.obj");
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
    const Mesh mesh = check(read_mesh(path)).mesh;
    ASSERT_EQ(mesh.triangles.size(), 69451u); // thesis table 4.2
    const Prisms prisms(mesh, 1, Gaps::Leave);
    const CoveringCounts counts = prisms.counts();
    EXPECT_EQ(counts.vertices, 34834);
    // 0.1 %: 30586 here; with edges of sine below 1e-5 as flat 30579, below 1e-4 30461.
    EXPECT_NEAR(counts.saddles, 30561, 30);
    // At a border there is no ring to cover; a program for closed meshes finds most uncovered.
    int border_vertices = 0;
    for (std::size_t i = 0; i < prisms.rings().count(); ++i)
        border_vertices += prisms.rings().is_closed(i) ? 0 : 1;
    EXPECT_EQ(border_vertices, 223);
    EXPECT_LE(counts.gaps, 516);
    EXPECT_GE(counts.gaps + border_vertices, 516);
}

TEST(Covering, NeighbouringLinesFindNearlyAllGaps) {
    const auto path = shared_data("bunny-closed.obj");
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
    const Mesh mesh = check(read_mesh(path)).mesh;
    const Prisms prisms(mesh, 1, Gaps::Leave);
    int gaps = 0;
    int missed = 0;
    for (std::size_t i = 0; i < prisms.rings().count(); ++i) {
        const bool is_found = prisms.has_gap(i);
        const bool is_there = !gap_edges(prisms, prisms.rings().ring(i)).empty();
        EXPECT_FALSE(is_found && !is_there);
        gaps += is_there ? 1 : 0;
        missed += is_there && !is_found ? 1 : 0;
    }
    // The thesis takes lines of neighbouring planes as sufficient; where the planes are not in
    // order around the vertex they are not. 2 %: 6 of 344 here.
    EXPECT_GT(gaps, 100);
    EXPECT_LE(missed, gaps / 50);
}

TEST(Covering, ConvexAndConcaveVerticesHaveNoGaps) {
    std::mt19937 random(4);
    for (int round = 0; round < 60; ++round) {
        Mesh mesh = random_hull(4 + 5 * round, random);
        for (const bool is_concave : {false, true}) {
            if (is_concave)
                for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
            const Prisms prisms(mesh, 1, Gaps::Leave);
            EXPECT_EQ(prisms.counts(),
                      (CoveringCounts{static_cast<int>(mesh.vertices_world.size()), 0, 0}));
            for (std::size_t i = 0; i < prisms.rings().count(); ++i)
                EXPECT_EQ(prisms.rings().kind(i),
                          is_concave ? VertexKind::Concave : VertexKind::Convex);
        }
    }
}

TEST(Covering, OfConvexVerticesHoldsEveryDirection) {
    std::mt19937 random(5);
    const Mesh mesh = random_hull(60, random);
    const Prisms prisms(mesh, 1, Gaps::Leave);
    for (std::size_t i = 0; i < prisms.rings().count(); ++i)
        for (int k = 0; k < 200; ++k)
            ASSERT_GE(multiplicity(mesh, prisms, prisms.rings().ring(i), random_unit(random)), 1);
}

TEST(Covering, IsPointSymmetricWithItsMultiplicity) {
    std::mt19937 random(6);
    const Mesh mesh = random_spiky_solid(150, random);
    const Prisms prisms(mesh, 1, Gaps::Leave);
    std::array<int, 4> seen{};
    for (std::size_t i = 0; i < prisms.rings().count(); ++i) {
        for (int k = 0; k < 50; ++k) {
            const Vec3d y = random_unit(random);
            const int count = multiplicity(mesh, prisms, prisms.rings().ring(i), y);
            ASSERT_EQ(multiplicity(mesh, prisms, prisms.rings().ring(i), -y), count);
            ++seen[std::min(count, 3)];
        }
    }
    EXPECT_GT(seen[0], 0); // gaps
    EXPECT_GT(seen[2], 0); // overlaps
}

TEST(SaddleGap, IsFoundAtAVertexOfValenceEightAndClosed) {
    const Mesh mesh = saddle_of_eight();
    const double half_width = 0.2; // well within the ring of radius 1
    const Prisms printed(mesh, half_width, Gaps::Leave);
    const Prisms closed(mesh, half_width, Gaps::Close);
    const OneRings& rings = printed.rings();
    std::size_t saddle = 0;
    while (mesh.triangles[rings.ring(saddle)[0] / 3][rings.ring(saddle)[0] % 3] != 0) ++saddle;
    EXPECT_EQ(rings.ring(saddle).size(), 8u);
    EXPECT_EQ(rings.kind(saddle), VertexKind::Saddle);
    EXPECT_TRUE(printed.has_gap(saddle));
    EXPECT_EQ(closed.counts(), printed.counts()); // as they were before closing

    const auto is_covered = [&](const Prisms& prisms, const Vec3d& p) {
        for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
            if (std::ranges::all_of(prisms.half_spaces(t), [&](const HalfSpace& h) {
                    return h.normal.dot(p) <= h.offset + scan_slack;
                }))
                return true;
        return false;
    };
    EXPECT_FALSE(is_covered(printed, Vec3d(0, 0, 0.1)));
    EXPECT_FALSE(is_covered(printed, Vec3d(0, 0, -0.1)));
    std::mt19937 random(7);
    std::uniform_real_distribution<double> radius(0, half_width);
    int uncovered = 0;
    for (int k = 0; k < 20000; ++k) {
        const Vec3d p = radius(random) * random_unit(random);
        uncovered += is_covered(printed, p) ? 0 : 1;
        ASSERT_TRUE(is_covered(closed, p)) << p.transpose();
    }
    EXPECT_GT(uncovered, 20);
}

TEST(SaddleGap, IsClosedAtEveryVertexWithinTheHalfWidth) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> weight(0, 1);
    for (const Mesh& mesh : {sample_mesh("knot"), random_spiky_solid(300, random)}) {
        const double half_width = 0.1;
        const Prisms printed(mesh, half_width, Gaps::Leave);
        const Prisms closed(mesh, half_width, Gaps::Close);
        int points = 0;
        int uncovered = 0;
        for (std::size_t i = 0; i < printed.rings().count(); ++i) {
            if (!printed.has_gap(i)) continue;
            const auto ring = printed.rings().ring(i);
            const std::vector<Vec3d> edges = gap_edges(printed, ring);
            for (int k = 0; k < 100; ++k) {
                Vec3d y = Vec3d::Zero();
                for (const Vec3d& edge : edges) y += weight(random) * edge;
                // 0.999: a point at the half width may round to beyond the shifted planes.
                y *= 0.999 * half_width / y.norm();
                uncovered += multiplicity(mesh, printed, ring, y) == 0 ? 1 : 0;
                ASSERT_GE(multiplicity(mesh, closed, ring, y), 1);
                ASSERT_GE(multiplicity(mesh, closed, ring, -y), 1);
                ++points;
            }
        }
        // Nearly all: a few are so near a plane that rounding decides.
        EXPECT_GT(points, 100);
        EXPECT_GT(uncovered, 0.99 * points);
    }
}

TEST(SaddleGap, ClosingOnlyShiftsOutwardAndByTheHalfWidthAtMost) {
    const Mesh mesh = sample_mesh("knot");
    const double half_width = 0.1;
    const Prisms printed(mesh, half_width, Gaps::Leave);
    const Prisms closed(mesh, half_width, Gaps::Close);
    int shifted = 0;
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
        const auto before = printed.half_spaces(t);
        const auto after = closed.half_spaces(t);
        for (std::size_t k = 0; k < 5; ++k) {
            EXPECT_EQ(before[k].normal, after[k].normal);
            const double shift = after[k].offset - before[k].offset;
            EXPECT_GE(shift, 0);
            EXPECT_LE(shift, half_width * (1 + 1e-15) + 1e-15); // rounding of the two offsets
            shifted += shift > 0 ? 1 : 0;
            if (k > 2) {
                EXPECT_EQ(shift, 0);
            }
        }
    }
    EXPECT_GT(shifted, 0);
}

TEST(Prisms, CoplanarNeighboursMeetInThePlanePerpendicularToTheirFace) {
    const Mesh mesh = cube();
    const Prisms prisms(mesh, 1, Gaps::Leave);
    EXPECT_EQ(prisms.counts(), (CoveringCounts{8, 0, 0}));
    int flat_edges = 0;
    for (int h = 0; h < static_cast<int>(3 * mesh.triangles.size()); ++h) {
        const HalfSpace lateral = prisms.half_spaces(h / 3)[h % 3];
        const double tilt = lateral.normal.dot(prisms.rings().face_normals[h / 3]);
        const bool is_flat = prisms.rings().bends[h] == Bend::Flat;
        flat_edges += is_flat ? 1 : 0;
        // Between faces of a cube the bisector stands at 45 degrees. 1e-15: a few roundings.
        EXPECT_NEAR(tilt, is_flat ? 0 : -std::sqrt(0.5), 1e-15);
        const int twin = prisms.rings().twins[h];
        EXPECT_EQ(prisms.half_spaces(twin / 3)[twin % 3].normal, -lateral.normal);
    }
    EXPECT_EQ(flat_edges, 12);
}

TEST(Prisms, EdgesOfMoreTrianglesOrOfBothOrientationsAreRefused) {
    Mesh flipped = cube();
    std::swap(flipped.triangles[0][0], flipped.triangles[0][1]);
    EXPECT_THROW(Prisms(flipped, 1, Gaps::Leave), InputError);
    Mesh finned = cube();
    finned.vertices_world.emplace_back(0, -2, -2);
    finned.triangles.push_back({0, 1, 8});
    EXPECT_THROW(Prisms(finned, 1, Gaps::Leave), InputError);
}

TEST(OneRings, HoldEachCornerOnceAndInOrder) {
    for (Mesh mesh : {sample_mesh("seashell"), cube()}) {
        for (const bool is_open : {false, true}) {
            if (is_open) mesh.triangles.pop_back();
            const OneRings rings = one_rings(mesh);
            std::vector<int> seen(3 * mesh.triangles.size(), 0);
            for (std::size_t i = 0; i < rings.count(); ++i) {
                const auto ring = rings.ring(i);
                for (std::size_t k = 0; k < ring.size(); ++k) {
                    ++seen[ring[k]];
                    if (k + 1 == ring.size() && !rings.is_closed(i)) continue;
                    // x_i+1 of triangle i is x_i of the next.
                    const int next = ring[(k + 1) % ring.size()];
                    EXPECT_EQ(apex_of(mesh, next), apex_of(mesh, ring[k]));
                    EXPECT_EQ(mesh.triangles[ring[k] / 3][(ring[k] + 2) % 3],
                              mesh.triangles[next / 3][(next % 3 + 1) % 3]);
                }
            }
            EXPECT_EQ(std::ranges::count(seen, 1), std::ssize(seen));
        }
    }
}

} // namespace
} // namespace isocast::test
