// The slice: a plane's tones and lines against fields that are known, and what hides it.
// SPDX-License-Identifier: MPL-2.0
#include "effect_rules.h"
#include "volume/errors.h"

namespace isocast::test {
namespace {

struct SlicePlane : Shading {
    /// What a ray through the middle of the pixel meets of the plane, from the eye or its start.
    Vec3d point_of(const Slice& slice, int x, int y) const {
        const Ray ray = camera_ray(camera, size, size, x + 0.5, y + 0.5);
        const Vec3d n = slice.normal.normalized();
        const double s =
            (slice.offset_world - n.dot(ray.origin_world)) / n.dot(ray.direction_world);
        return ray.origin_world + s * ray.direction_world;
    }
    Eigen::Vector4d pixel(const Image& image, int x, int y) const {
        const float* p = &image.rgba[4 * static_cast<std::size_t>(size * y + x)];
        return {p[0], p[1], p[2], p[3]};
    }
};

/// Tones of a torus' distance, by eyes and by parallel rays, through a slanted plane.
TEST_F(SlicePlane, HasTheTonesOfTheFieldsValues) {
    const AnalyticField torus = builtin_field("torus");
    Scene scene{.field = sampled(torus, 64)};
    scene.look.effects.slice = {.strength = 1,
                                .normal = {0.2, -0.3, 2},
                                .offset_world = 0.6, // above the torus: nothing is hidden
                                .spacing_world = 100,
                                .range_world = 1,
                                .inside = {0, 0, 1},
                                .outside = {1, 0, 0}};
    const Slice& slice = scene.look.effects.slice;
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        camera.height_world = 3;
        const Image image = draw(scene, FrameImage::Slice);
        int count = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const Eigen::Vector4d seen = pixel(image, x, y);
                const Vec3d p = point_of(slice, x, y);
                // The texture ends up to a texel before the extent's faces, half a voxel.
                const double reach = p.cwiseAbs().maxCoeff();
                if (reach > 1.75) {
                    EXPECT_EQ(seen.w(), 0) << x << ' ' << y;
                } else if (reach < 1.75 - 3.5 / 63) {
                    ASSERT_EQ(seen.w(), 1) << x << ' ' << y;
                }
                const double value = torus.jet(p).value;
                const double axis = p.head<2>().norm();
                // Beside the crease on the axis, the thick line of iso, and the extent's border,
                // beyond which samples continue.
                if (seen.w() == 0 || reach > 1.6 || axis < 0.2 || std::abs(value) < 0.15 ||
                    value > 1)
                    continue;
                ++count;
                // From paper, 0.92, to the full tone at 1.
                const double t = value > 0 ? (0.92 - seen.y()) / 0.92 : -(0.92 - seen.x()) / 0.92;
                // Texels are half a voxel, h = 0.028: bilinear errs by h^2/8 of the second
                // derivatives, whose sum is below 1/0.15 + 1/0.2 here, 1.1e-3; Catmull-Rom by
                // terms of third order, less; halves of 0.5 to 1 by 2.5e-4.
                EXPECT_NEAR(t, value, 1.5e-3) << x << ' ' << y;
            }
        EXPECT_GT(count, 1000);
    }
}

TEST_F(SlicePlane, HasLinesWhereTheValueIsAMultipleOfTheSpacing) {
    size = 256;
    camera = {.eye_world = {0, 0, 5},
              .target_world = Vec3d::Zero(),
              .projection = Projection::Orthographic,
              .height_world = 3};
    Scene scene{.field = sampled(builtin_field("sphere"), 64)};
    scene.iso_world = 0.4; // below the plane
    scene.look.effects.slice = {.strength = 1,
                                .normal = {0, 0, 3},
                                .offset_world = 1.45,
                                .spacing_world = 0.1,
                                .inside = Vec3d::Ones(),
                                .outside = Vec3d::Ones(),
                                .line = Vec3d::Zero()};
    const Image image = draw(scene, FrameImage::Slice);
    int on_lines = 0, between = 0;
    const double pixel_world = 3.0 / size;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const Eigen::Vector4d seen = pixel(image, x, y);
            const Vec3d p = point_of(scene.look.effects.slice, x, y);
            // Two voxels from the border, beyond which samples continue.
            if (p.head<2>().cwiseAbs().maxCoeff() > 1.5 - 2 * 3.0 / 63) continue;
            ASSERT_EQ(seen.w(), 1);
            const double value = p.norm() - 1;
            const double slope = pixel_world * p.head<2>().norm() / p.norm(); // to the next pixel
            if (slope < 0.25 * pixel_world || std::abs(value - 0.4) < 4 * slope) continue;
            const double pixels = std::abs(value - 0.1 * std::round(value / 0.1)) / slope;
            // Half a pixel wide on each side, and smoothed by half a pixel; a tenth for the
            // slope, which the texture has constant over a texel.
            if (pixels > 1.1) {
                ++between;
                EXPECT_GT(seen.y(), 0.9) << x << ' ' << y;
            } else if (pixels < 0.1) {
                ++on_lines;
                EXPECT_LT(seen.y(), 0.5) << x << ' ' << y;
            }
        }
    EXPECT_GT(on_lines, 100);
    EXPECT_GT(between, 10000);
}

TEST_F(SlicePlane, IsHiddenByWhatIsBeforeItAndShowsBesideTheSurface) {
    camera = {.eye_world = {0, 0, 5}, .target_world = Vec3d::Zero()};
    Scene scene{.field = sampled(builtin_field("sphere"), 48)};
    scene.look.effects.slice.strength = 1; // z = 0
    const Image image = draw(scene, FrameImage::Slice);
    const Image hits = renderer.read(FrameImage::Hit);
    int shown = 0, hidden = 0;
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
        hidden += hits.rgba[i] != 0;
        shown += image.rgba[i] == 1;
        // All of the half of the ball that is seen lies before the plane.
        if (hits.rgba[i] != 0) {
            EXPECT_EQ(image.rgba[i], 0);
        }
    }
    EXPECT_GT(hidden, 500);
    EXPECT_GT(shown, 1000);
    // From above, at z = 1.2, it hides all; and it is there where no surface is in sight.
    scene.look.effects.slice.offset_world = 1.2;
    EXPECT_EQ(pixel(draw(scene, FrameImage::Slice), size / 2, size / 2).w(), 1);
    camera.eye_world = {1.4, 0, 1.2};
    camera.target_world = {1.41, 0, 0};
    scene.look.effects.slice.offset_world = 1.0;
    const Image beauty = draw(scene);
    EXPECT_EQ(pixel(beauty, size / 2, size / 2).w(), 1);
}

TEST_F(SlicePlane, IsRefusedWhereThereIsNoSuchField) {
    Scene scene{.field = sampled(builtin_field("sphere"), 16)};
    scene.look.effects.slice = {.strength = 1, .normal = Vec3d::Zero()};
    EXPECT_THROW(renderer.load(scene), InputError);
    scene.look.effects.slice = {.strength = 1, .spacing_world = -1.0};
    EXPECT_THROW(renderer.load(scene), InputError);
    auto primitives = std::make_shared<Primitives>();
    primitives->spheres.push_back({.radius_world = 1});
    EXPECT_THROW(
        renderer.load({.look = {.effects = {.slice = {.strength = 1}}}, .primitives = primitives}),
        InputError);
}

TEST_F(SlicePlane, IsNothingAtStrengthZero) {
    Look look;
    look.effects.slice = {.strength = 0, .normal = {1, 2, 3}, .spacing_world = 0.1};
    expect_nothing_at_strength_zero(*this, look);
}

TEST_F(SlicePlane, AloneNeedsHitsAlone) {
    expect_no_more_passes(*this, FrameImage::Slice, {"raycast", "slice"});
}

TEST_F(SlicePlane, IsFiniteAnywhere) {
    expect_finite_anywhere(*this, FrameImage::Slice);
}

} // namespace
} // namespace isocast::test
