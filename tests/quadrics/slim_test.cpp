// SLIM surfaces: the formulas of a patch against others, covers against shapes with a closed form,
// files whole and damaged.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "quad_cube.h"
#include "quadrics/slim_cover.h"
#include "quadrics/slim_file.h"
#include "random_primitives.h"
#include "volume/errors.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <fstream>
#include <functional>
#include <numbers>

namespace isocast {
namespace {

SlimPatch random_patch(Random& random) {
    SlimPatch patch{.centre_world = random.in_cube(3),
                    .radius_world = random.log_uniform(0.1, 3),
                    .normal = random.unit()};
    patch.height[0] = random.uniform(-0.2, 0.2) * patch.radius_world;
    for (std::size_t i = 1; i < 3; ++i) patch.height[i] = random.uniform(-0.3, 0.3);
    for (std::size_t i = 3; i < 6; ++i)
        patch.height[i] = random.uniform(-1, 1) / patch.radius_world;
    return patch;
}

double height_over(const SlimPatch& patch, const Vec3d& p_world) {
    const Vec3d q = slim_axes(patch.normal).transpose() * (p_world - patch.centre_world);
    const auto& h = patch.height;
    return q.z() - (h[0] + h[1] * q.x() + h[2] * q.y() + h[3] * q.x() * q.x() +
                    h[4] * q.x() * q.y() + h[5] * q.y() * q.y());
}

/// quad_cube(), each quad in two.
TriangleMesh cube(int n, const std::function<Vec3d(const Vec3d&)>& moved) {
    const PatchMesh quads = test::quad_cube(n, moved);
    TriangleMesh mesh{.vertices_world = quads.vertices_world};
    for (const auto& [a, b, c, d] : quads.quads) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
    }
    return mesh;
}
TriangleMesh ball(int n) {
    return cube(n, [](const Vec3d& p) { return Vec3d(p.normalized()); });
}

/// How far from the surface of the cube.
double distance_to_cube(const Vec3d& p) {
    const Vec3d outside = (p.cwiseAbs() - Vec3d::Ones()).cwiseMax(0);
    return outside.isZero(0) ? 1 - p.cwiseAbs().maxCoeff() : outside.norm();
}

struct Met {
    double greatest_off = 0; // of all hits, from the surface
    int missed = 0;
};
/// Rays against the normals of random points of the mesh, from `reach` in front of it to as far
/// behind: a second way to the surface than by heights.
Met met_by_rays(const TriangleMesh& mesh, const SlimSurface& surface, double reach, int count,
                const std::function<double(const Vec3d&)>& distance) {
    Random random(7);
    Met met;
    for (int i = 0; i < count; ++i) {
        const auto number = static_cast<std::size_t>(
            random.uniform(0, static_cast<double>(mesh.triangles.size()) - 1e-9));
        const Triangle triangle = triangle_of(mesh, number);
        const double u = std::sqrt(random.uniform(0, 1));
        const double v = random.uniform(0, 1);
        const auto& [a, b, c] = triangle.corners_world;
        const Vec3d p = (1 - u) * a + u * ((1 - v) * b + v * c);
        const Vec3d n = area_normal(triangle).normalized();
        bool is_met = false;
        for (const SlimPatch& patch : surface.levels.front().patches)
            for (const SlimHit& hit : intersect(patch, p + reach * n, -n, true)) {
                if (hit.t > 2 * reach) continue;
                is_met = true;
                met.greatest_off = std::max(met.greatest_off, distance(p + (reach - hit.t) * n));
            }
        met.missed += is_met ? 0 : 1;
    }
    return met;
}

TEST(Slim, HitsLieOnTheGraphAndNormalsAreItsGradient) {
    Random random(1);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const SlimPatch patch = random_patch(random);
        const Vec3d origin = patch.centre_world + 4 * patch.radius_world * random.unit();
        const Vec3d target = patch.centre_world + 0.5 * patch.radius_world * random.unit();
        const Vec3d v = (target - origin) * random.log_uniform(0.1, 10);
        for (const SlimHit& hit : intersect(patch, origin, v, false)) {
            ++hits;
            const Vec3d p = origin + hit.t * v;
            // Roundings of places 10 radii away, times those of grazing roots.
            EXPECT_LT(std::abs(height_over(patch, p)), 1e-10 * patch.radius_world);
            EXPECT_LT((p - patch.centre_world).norm(), patch.radius_world);
            // The central difference is exact for quadratic functions.
            Vec3d gradient;
            const double step = patch.radius_world / 16;
            for (int k = 0; k < 3; ++k)
                gradient[k] = (height_over(patch, p + step * Vec3d::Unit(k)) -
                               height_over(patch, p - step * Vec3d::Unit(k))) /
                              (2 * step);
            EXPECT_LT((gradient.normalized() - hit.normal).norm(), 1e-9);
        }
    }
    EXPECT_GT(hits, 1000);
}

TEST(Slim, ImplicitFormIsTheGraphs) {
    Random random(2);
    for (int i = 0; i < 1000; ++i) {
        const SlimPatch patch = random_patch(random);
        const SlimQuadric f = slim_quadric(patch);
        const Vec3d p = patch.radius_world * random.in_cube(1);
        EXPECT_NEAR(p.dot(f.a * p + 2 * f.b) + f.c, height_over(patch, patch.centre_world + p),
                    1e-12 * patch.radius_world); // some roundings of what is as large as the radius
    }
}

TEST(Slim, WeightIsSmoothAndEndsOnTheSphere) {
    EXPECT_EQ(slim_weight(0), 1);
    EXPECT_EQ(slim_weight(1), 0);
    const double h = 1e-6;
    const auto slope = [&](double s) {
        return (slim_weight(s + h) - slim_weight(s - h)) / (2 * h);
    };
    for (double s = 0.01; s < 1.2; s += 0.01) EXPECT_LE(slope(s), 0);
    // The second derivative is below 10: so far may slopes differ over 2 h on either side.
    for (const double s : {0.5, 1.0}) EXPECT_NEAR(slope(s - 2 * h), slope(s + 2 * h), 40 * h);
    EXPECT_NEAR(slim_weight(0.5 - h), slim_weight(0.5 + h), 4 * h);
}

TEST(Slim, TurnedAwayPatchesShowNoRayTheirOuterSide) {
    Random random(3);
    int turned = 0;
    for (int i = 0; i < 2000; ++i) {
        const SlimPatch patch = random_patch(random);
        const bool is_perspective = random.coin();
        const Vec3d eye =
            patch.centre_world + random.log_uniform(1.5, 20) * patch.radius_world * random.unit();
        const Vec3d view = (patch.centre_world - eye).normalized();
        if (!is_turned_away(patch, eye, is_perspective, view)) continue;
        ++turned;
        for (int k = 0; k < 200; ++k) {
            const Vec3d target = patch.centre_world + patch.radius_world * random.in_cube(1);
            const Vec3d origin = is_perspective ? eye : Vec3d(target - 20 * view);
            EXPECT_TRUE(intersect(patch, origin, target - origin, true).empty());
        }
    }
    EXPECT_GT(turned, 200); // a seventh of all, so that the test tests something
}

TEST(SlimCover, BallIsCoveredWithinTheError) {
    const TriangleMesh mesh = ball(40);
    SlimReport report;
    const double error = 2e-3;
    const SlimSurface surface = slim_of(mesh, {.max_error_world = error}, report);
    EXPECT_TRUE(surface.is_closed);
    EXPECT_EQ(report.over_bound, 0U);
    EXPECT_LT(surface.levels.front().patches.size(), mesh.triangles.size() / 20);
    const Met met = met_by_rays(mesh, surface, 0.1, 5000,
                                [](const Vec3d& p) { return std::abs(p.norm() - 1); });
    EXPECT_EQ(met.missed, 0);
    // Between vertices by 2 bows of the longest edge, 2/40 sqrt(2) long, more: L^2 / 8 each.
    EXPECT_LT(met.greatest_off, error + 0.5 * 0.05 * 0.05);
}

TEST(SlimCover, CubeKeepsItsEdges) {
    for (const int n : {1, 8}) {
        const TriangleMesh mesh = cube(n, [](const Vec3d& p) { return p; });
        SlimReport report;
        const double error = 4e-3;
        const SlimSurface surface = slim_of(mesh, {.max_error_world = error}, report);
        EXPECT_EQ(report.over_bound, 0U);
        EXPECT_GT(report.with_planes, 0U);
        const Met met = met_by_rays(mesh, surface, 0.1, 5000, distance_to_cube);
        EXPECT_EQ(met.missed, 0);
        // Faces are flat, where a patch with ends is off by half the error, and half of it longer.
        EXPECT_LT(met.greatest_off, error);
        // Nothing sticks out: rays past the edges, a little more than an error away, miss.
        Random random(5);
        for (int i = 0; i < 3000; ++i) {
            const Vec3d origin(random.uniform(-1, 1), 1 + 1.1 * error, 3);
            for (const SlimPatch& patch : surface.levels.front().patches)
                EXPECT_TRUE(intersect(patch, origin, -Vec3d::UnitZ(), false).empty());
        }
    }
}

TEST(SlimCover, FlatSheetEndsWhereItDoes) {
    TriangleMesh mesh{.vertices_world = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                      .triangles = {{0, 1, 2}, {0, 2, 3}}};
    SlimReport report;
    const double error = 1e-3;
    const SlimSurface surface = slim_of(mesh, {.max_error_world = error}, report);
    EXPECT_FALSE(surface.is_closed);
    EXPECT_EQ(report.over_bound, 0U);
    const Met met =
        met_by_rays(mesh, surface, 0.1, 3000, [](const Vec3d& p) { return std::abs(p.z()); });
    EXPECT_EQ(met.missed, 0);
    EXPECT_LT(met.greatest_off, 1e-12); // least squares of what is flat: roundings
    Random random(6);
    for (int i = 0; i < 2000; ++i) {
        const Vec3d beyond(1 + random.uniform(1.01, 100) * error, random.uniform(0, 1), 1);
        for (const SlimPatch& patch : surface.levels.front().patches)
            EXPECT_TRUE(intersect(patch, beyond, -Vec3d::UnitZ(), false).empty());
    }
}

// A prism over a lens whose two sides are as good as one line: planes along both keep a strip,
// which must end with the lens.
TEST(SlimCover, NoNeedleSticksOutOfASliver) {
    const double error = 4e-3;
    TriangleMesh mesh;
    for (const double z : {0.0, 1.0})
        for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.5, -8e-4}, {1.0, 0.0}, {0.5, 8e-4}})
            mesh.vertices_world.emplace_back(x, y, z);
    mesh.triangles = {{4, 5, 6}, {4, 6, 7}, {0, 2, 1}, {0, 3, 2}};
    for (const int k : {0, 1, 2, 3}) {
        const int next = (k + 1) % 4;
        mesh.triangles.push_back({k, next, next + 4});
        mesh.triangles.push_back({k, next + 4, k + 4});
    }
    SlimReport report;
    const SlimSurface surface = slim_of(mesh, {.max_error_world = error}, report);
    Random random(9);
    for (int i = 0; i < 3000; ++i) {
        // The least spheres have three errors.
        const double beyond = random.uniform(4 * error, 0.6);
        const Vec3d origin(random.coin() ? 1 + beyond : -beyond, random.uniform(-error, error), 3);
        for (const SlimPatch& patch : surface.levels.front().patches)
            EXPECT_TRUE(intersect(patch, origin, -Vec3d::UnitZ(), false).empty()) << beyond;
    }
}

TEST(SlimCover, ThreadsDoNotMatter) {
    const TriangleMesh mesh = cube(16, [](const Vec3d& p) {
        return Vec3d(p +
                     0.1 * Vec3d(std::sin(3 * p.y()), std::sin(4 * p.z()), std::sin(5 * p.x())));
    });
    std::vector<SlimSurface> made;
    for (const std::size_t threads : {1, 3}) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        SlimReport report;
        made.push_back(slim_of(mesh, {.max_error_world = 2e-3}, report));
    }
    const test::TemporaryFolder folder;
    const auto bytes = [&](const SlimSurface& surface, const std::string& name) {
        write_slim(surface, folder / name);
        std::ifstream file(folder / name, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(file), {});
    };
    EXPECT_EQ(bytes(made[0], "one.slim"), bytes(made[1], "three.slim"));
}

class SlimFile : public testing::Test {
protected:
    std::string written() {
        Random random(4);
        surface_ = {.levels = {{.patches = {}, .max_error_world = 0.01},
                               {.patches = {}, .max_error_world = 0.04}},
                    .is_closed = true};
        for (int i = 0; i < 3; ++i) surface_.levels[0].patches.push_back(random_patch(random));
        surface_.levels[1].patches.push_back(random_patch(random));
        SlimPatch& clipped = surface_.levels[0].patches[1];
        clipped.plane_count = 2;
        clipped.is_any = true;
        clipped.planes = {{{random.unit(), 0.25}, {random.unit(), -0.5}}};
        write_slim(surface_, path_);
        std::ifstream file(path_, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    void write(const std::string& bytes) { std::ofstream(path_, std::ios::binary) << bytes; }
    test::TemporaryFolder folder_;
    std::filesystem::path path_ = folder_ / "some.slim";
    SlimSurface surface_;
};

TEST_F(SlimFile, ComesBackBitForBit) {
    const std::string bytes = written();
    const SlimSurface read = read_slim(path_);
    ASSERT_EQ(read.levels.size(), 2U);
    const auto& patches = read.levels[0].patches;
    ASSERT_EQ(patches.size(), 3U);
    EXPECT_EQ(patches[1].planes[1].normal, surface_.levels[0].patches[1].planes[1].normal);
    EXPECT_EQ(patches[2].height, surface_.levels[0].patches[2].height);
    EXPECT_TRUE(read.is_closed && patches[1].is_any);
    EXPECT_EQ(read.levels[1].max_error_world, 0.04);
    EXPECT_EQ(read.levels[1].patches.at(0).height, surface_.levels[1].patches[0].height);
    write_slim(read, path_);
    std::ifstream file(path_, std::ios::binary);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), bytes);
}

TEST_F(SlimFile, CutShortOrLongerIsRefused) {
    const std::string bytes = written();
    for (std::size_t length = 0; length < bytes.size(); ++length) {
        write(bytes.substr(0, length));
        EXPECT_THROW(read_slim(path_), InputError) << length;
    }
    write(bytes + '\0');
    EXPECT_THROW(read_slim(path_), InputError);
}

TEST_F(SlimFile, AnyChangedByteIsRefused) {
    const std::string bytes = written();
    Random random(8);
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        std::string damaged = bytes;
        damaged[at] =
            static_cast<char>(damaged[at] ^ (1 << static_cast<int>(random.uniform(0, 8))));
        write(damaged);
        EXPECT_THROW(read_slim(path_), InputError) << at;
    }
}

TEST_F(SlimFile, OtherVersionsAreRefusedByNumber) {
    std::string bytes = written();
    bytes[8] = 1;
    write(bytes);
    try {
        read_slim(path_);
        ADD_FAILURE() << "read";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("version 1, not 2"), std::string::npos);
    }
}

TEST(Slim, BoxHoldsTheSpheresOfTheFinestLevel) {
    Random random(9);
    SlimSurface surface{.levels = {{}, {}}};
    for (int i = 0; i < 5; ++i) surface.levels[0].patches.push_back(random_patch(random));
    surface.levels[1].patches.push_back(random_patch(random));
    EXPECT_EQ(surface.patch_count(), 6U);
    for (int axis = 0; axis < 3; ++axis) {
        double low = 1e9;
        double high = -1e9;
        for (const SlimPatch& patch : surface.levels[0].patches) {
            low = std::min(low, patch.centre_world[axis] - patch.radius_world);
            high = std::max(high, patch.centre_world[axis] + patch.radius_world);
        }
        EXPECT_EQ(box_of(surface).min()[axis], low);
        EXPECT_EQ(box_of(surface).max()[axis], high);
    }
    EXPECT_TRUE(box_of(SlimSurface{}).isEmpty());
}

TEST_F(SlimFile, WrongPatchesAreRefusedByName) {
    const auto message = [&](const std::function<void(SlimSurface&)>& change) {
        written();
        SlimSurface wrong = surface_;
        change(wrong);
        try {
            check(wrong);
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(message([](SlimSurface& s) { s.levels[0].patches[2].radius_world = -1; }),
              "SLIM level 0, patch 2: its radius is not positive");
    EXPECT_EQ(message([](SlimSurface& s) { s.levels[0].patches[0].normal *= 2; }),
              "SLIM level 0, patch 0: its normal is not of unit length");
    EXPECT_EQ(message([](SlimSurface& s) { s.levels[0].patches[2].height[4] = std::nan(""); }),
              "SLIM level 0, patch 2: its function is not finite");
    EXPECT_EQ(message([](SlimSurface& s) { s.levels[0].patches[2].plane_count = 3; }),
              "SLIM level 0, patch 2: it has more than two planes");
    EXPECT_EQ(message([](SlimSurface& s) { s.levels[1].patches[0].radius_world = 0; }),
              "SLIM level 1, patch 0: its radius is not positive");
    EXPECT_EQ(message([](SlimSurface& s) { s.levels[0].max_error_world = 0; }),
              "SLIM level 0: its error 0 is not positive");
    EXPECT_EQ(message([](SlimSurface& s) { s.levels[1].max_error_world = 0.01; }),
              "SLIM level 1: its error is not above that of the finer level");
    EXPECT_EQ(message([](SlimSurface& s) { s.levels.clear(); }), "SLIM: it has no level");
}

} // namespace
} // namespace isocast
