// Crowds of spheres and sticks that are thinner than pixels, thinned out.
// SPDX-License-Identifier: MPL-2.0
#include "../quadrics/random_primitives.h"
#include "raycaster/renderer.h"
#include "raycaster/splats_on_gpu.h"
#include "renderer_test_base.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isocast::test {
namespace {

constexpr int width = 128;
constexpr int height = 96;

/// Frames of 128 x 96 pixels, seen from so far away that the unit cube is 80 of them wide.
struct Details : RendererTest {
    double distance = 40;

    Camera camera(double x = 0) const {
        Camera seen{.eye_world = {x, 0.1, distance}, .target_world = {x, 0.1, 0}};
        seen.fov_y_degrees = 2 * std::atan(0.6 / distance) * 180 / std::numbers::pi;
        return seen;
    }
    double pixels_per_world() const { return height / 1.2; }

    int drawn(const Primitives& primitives, double detail_pixels) const {
        const SplatsOnGpu splats(primitives, {}, camera(), width, height,
                                 {.width = width, .height = height}, detail_pixels);
        int count = 0;
        for (const SplatsOnGpu::OfKind& of_kind : splats.kinds) count += of_kind.count;
        return count;
    }
    std::vector<bool> covered(const Camera& from) {
        renderer.draw(from, width, height, {FrameImage::Hit});
        const Image hits = renderer.read(FrameImage::Hit);
        std::vector<bool> pixels;
        for (std::size_t i = 3; i < hits.rgba.size(); i += 4) pixels.push_back(hits.rgba[i] != 0);
        return pixels;
    }
    void load(const Primitives& primitives, double detail_pixels) {
        renderer.load({.quality = {.detail_pixels = detail_pixels},
                       .primitives = std::make_shared<Primitives>(primitives)});
    }
};

Primitives spheres_in_a_cube(int count, double radius, std::uint64_t seed = 3) {
    Random random(seed);
    Primitives primitives;
    for (int i = 0; i < count; ++i)
        primitives.spheres.push_back({.centre_world = random.in_cube(0.5), .radius_world = radius});
    return primitives;
}

/// By numbers: the areas of what is drawn add up to those of all. None hides another.
TEST_F(Details, OfMeanAreaAreAsTheyWouldBe) {
    constexpr int side = 450;
    constexpr int count = side * side;
    constexpr double spacing_pixels = 4;
    for (const double radius_pixels : {0.1, 0.25, 0.5}) {
        const double r = radius_pixels; // world units are pixels
        Primitives all;
        for (int i = 0; i < count; ++i) {
            const Vec3d at(spacing_pixels * (i % side), spacing_pixels * (i / side), 0);
            all.spheres.push_back({.centre_world = at, .radius_world = r});
            all.cylinders.push_back({.a_world = at + Vec3d(2, 0, 0),
                                     .b_world = at + Vec3d(2, 2, 0),
                                     .radius_world = r});
        }
        constexpr int size = static_cast<int>(spacing_pixels) * side;
        SplatView view{.space = {.eye_world = {size / 2.0, size / 2.0, 10},
                                 .view_from_world = Mat3d::Identity(),
                                 .is_perspective = false},
                       .pixels_per_unit = 1,
                       .middle_pixels = {size / 2.0, size / 2.0},
                       .width = size,
                       .height = size};
        view.detail_pixels = 0.7;
        const Splats drawn = splats_of(all, view);
        double area = 0; // by that of all
        const std::vector<float>& spheres = drawn.records[std::size_t(SplatKind::Sphere)];
        for (std::size_t i = 11; i < spheres.size(); i += splat_floats[0])
            area += std::pow(double(spheres[i]) / r, 2) / count;
        double thickness = 0;
        const auto of_cone = std::size_t(SplatKind::Cone);
        const std::vector<float>& sticks = drawn.records[of_cone];
        for (std::size_t i = 16; i < sticks.size(); i += std::size_t(splat_floats[of_cone]))
            thickness += 1 / (double(sticks[i]) * r) / count;
        // Of a share q that is kept each counts 1 / q times: the mean of `count` such numbers
        // varies by less than sqrt(1 / q / count); four of these.
        const double q = radius_pixels / 0.7;
        EXPECT_NEAR(area, 1, 4 / std::sqrt(q * q * count)) << radius_pixels;
        EXPECT_NEAR(thickness, 1, 4 / std::sqrt(q * count)) << radius_pixels;
        const auto with_growing = [](double kept) { return kept + std::min(kept / 4, 1 - kept); };
        EXPECT_NEAR(drawn.count(SplatKind::Sphere) / double(count), with_growing(q * q), 0.01);
        EXPECT_NEAR(drawn.count(SplatKind::Cone) / double(count), with_growing(q), 0.01);
    }
}

/// By pixels: of twelve crowds that cover a tenth of the picture each.
TEST_F(Details, CoverAsManyPixels) {
    for (const double radius_pixels : {0.25, 0.5}) {
        const double r = radius_pixels / pixels_per_world();
        std::array<int, 2> covered_pixels{};
        for (std::uint64_t seed = 1; seed <= 12; ++seed)
            for (const bool is_thinned : {false, true}) {
                load(spheres_in_a_cube(int(0.06 / (r * r)), r, seed), is_thinned ? 0.7 : 0);
                for (const bool is_covered : covered(camera()))
                    covered_pixels[std::size_t(is_thinned)] += is_covered;
            }
        // Counts of independent things vary by their root; a disc of 1.5 pixels counts as often.
        EXPECT_GT(covered_pixels[0], 9000);
        EXPECT_NEAR(covered_pixels[1], covered_pixels[0], 3 * std::sqrt(2.5 * covered_pixels[0]));
    }
}

TEST_F(Details, DoNotFlicker) {
    const Primitives all = spheres_in_a_cube(20000, 0.25 / pixels_per_world());
    std::array<double, 2> changes{};
    for (const bool is_thinned : {false, true}) {
        load(all, is_thinned ? 1.5 : 0);
        std::vector<bool> before = covered(camera());
        for (int view = 1; view <= 20; ++view) {
            const std::vector<bool> now = covered(camera(2e-3 * view)); // a 6th of a pixel
            for (std::size_t i = 0; i < now.size(); ++i)
                changes[static_cast<std::size_t>(is_thinned)] += now[i] != before[i];
            before = now;
        }
    }
    // A disc of radius R that moves by d changes 2 d / (pi R / 2) of its area, of 0.25 and 1.5
    // pixels: a sixth of the changes; what covers what makes it more.
    EXPECT_LT(changes[1], changes[0] / 3);
}

TEST_F(Details, LeaveWhatIsLargerAsItIs) {
    const Primitives all = spheres_in_a_cube(2000, 2 / pixels_per_world());
    load(all, 0);
    const std::vector<bool> exact = covered(camera());
    load(all, 1);
    EXPECT_EQ(covered(camera()), exact);
    EXPECT_EQ(drawn(all, 1), drawn(all, 0));
}

/// From all of them to a few, and each step of the way has those of the next.
TEST_F(Details, ComeAndGoOneByOne) {
    const Primitives all = spheres_in_a_cube(20000, 0.3 / pixels_per_world());
    int before = drawn(all, 0.2);
    EXPECT_EQ(before, drawn(all, 0));
    for (const double detail : {0.4, 0.8, 1.6, 3.2}) {
        const int now = drawn(all, detail);
        EXPECT_LT(now, before);
        before = now;
    }
    EXPECT_NEAR(before / 20000.0, 1.25 * std::pow(0.3 / 3.2, 2), 0.005);
}

TEST_F(Details, ThatCannotBeAreRefused) {
    for (const double pixels : {-1.0, 5.0, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_THROW(load(spheres_in_a_cube(1, 1), pixels), InputError);
}

} // namespace
} // namespace isocast::test
