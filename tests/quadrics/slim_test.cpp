// SLIM surfaces: the formulas of a patch against others, files whole and damaged.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "quadrics/slim_file.h"
#include "random_primitives.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

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
        clipped.errors = 2.5;
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
    EXPECT_EQ(patches[1].errors, 2.5);
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
        EXPECT_NE(std::string(error.what()).find("version 1, not 3"), std::string::npos);
    }
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
    EXPECT_EQ(message([](SlimSurface& s) { s.levels[0].patches[1].errors = 0.5; }),
              "SLIM level 0, patch 1: it may be off by less than the error");
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
