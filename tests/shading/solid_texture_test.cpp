// Solid textures against exact averages, the same texture elsewhere, and double twins.
// SPDX-License-Identifier: MPL-2.0
#include "shading_scene.h"

#include "filtering/reconstruct.h"
#include "raycaster/fetch_choice.h"
#include "volume/dense_field.h"
#include "volume/errors.h"

#include "../volume/random_fields.h"

namespace isocast::test {
namespace {

using Kind = SolidTexture::Kind;

/// The layer's texels are halves: 2^-11 of a value near 1, which software GLs cut off.
constexpr double half_rounding = 1.0 / 2048;

/// The second colour's share is the first channel.
SolidTexture black_and_white(Kind kind, double scale_world) {
    return {.strength = 1,
            .kind = kind,
            .scale_world = scale_world,
            .colour_a = {0, 0, 0},
            .colour_b = {1, 1, 1}};
}

double fraction(double t) {
    return t - std::floor(t);
}

/// Mean over [lo, hi] of what is 0 in the first half of each period and 1 in the second.
double mean_of_steps(double lo, double hi) {
    const auto integral = [](double t) {
        return 0.5 * std::floor(t) + std::max(fraction(t) - 0.5, 0.0);
    };
    return (integral(hi) - integral(lo)) / (hi - lo);
}

/// Twin of shaders/shading/solid_texture/noise.glsl.
double noise(const Vec3d& p) {
    const Vec3d cell = p.array().floor();
    const Vec3d a = p - cell;
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Index3 at(corner & 1, corner >> 1 & 1, corner >> 2);
        std::array<std::uint32_t, 3> v{};
        double weight = 1;
        for (int i = 0; i < 3; ++i) {
            v[std::size_t(i)] =
                std::uint32_t((int(cell[i]) + at[i]) & 255) * 1664525U + 1013904223U;
            const double fade = a[i] * a[i] * a[i] * (a[i] * (a[i] * 6 - 15) + 10);
            weight *= at[i] == 1 ? fade : 1 - fade;
        }
        const auto mix = [&] {
            v[0] += v[1] * v[2];
            v[1] += v[2] * v[0];
            v[2] += v[0] * v[1];
        };
        mix();
        for (std::uint32_t& bits : v) bits ^= bits >> 16;
        mix();
        for (int i = 0; i < 3; ++i)
            sum += weight * ((v[std::size_t(i)] >> 8) / 8388608.0 - 1) * (a[i] - at[i]);
    }
    return sum;
}

struct SolidTextures : Shading {
    const std::shared_ptr<const FieldSource> plane = sampled(
        {"plane",
         [](const Vec3d& p) {
             return Jet{.value = p.z(), .gradient = Vec3d::UnitZ(), .hessian = Mat3d::Zero()};
         },
         1},
        32);
    const std::shared_ptr<const FieldSource> torus = sampled(builtin_field("torus"), 48);
    /// Sees the plane from above; pixels are 1.5/size wide.
    Camera above{.eye_world = {0.01, 0.02, 3},
                 .target_world = {0.01, 0.02, 0},
                 .projection = Projection::Orthographic,
                 .height_world = 1.5};
    double pixel_world = 1.5 / 96;

    Image texture(const std::shared_ptr<const FieldSource>& field, const SolidTexture& solid) {
        Scene scene{.field = field};
        scene.look.effects.solid_texture = solid;
        return draw(scene, FrameImage::SolidTexture);
    }
    /// Centre of a pixel of `above`.
    Vec3d on_plane(int x, int y) const {
        return {above.eye_world.x() + (x + 0.5 - 0.5 * size) * pixel_world,
                above.eye_world.y() + (0.5 * size - y - 0.5) * pixel_world, 0};
    }
    /// Calls visit(p_world, share, alpha) for each hit; returns their number.
    template<class Visit>
    int for_each_texel(const std::shared_ptr<const FieldSource>& field, const SolidTexture& solid,
                       Visit visit) {
        Scene scene{.field = field};
        scene.look.effects.solid_texture = solid;
        renderer.load(scene);
        renderer.draw(camera, size, size, {FrameImage::Hit, FrameImage::SolidTexture});
        const Image hits = renderer.read(FrameImage::Hit);
        const Image image = renderer.read(FrameImage::SolidTexture);
        int count = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            EXPECT_EQ(image.rgba[i + 3], hits.rgba[i + 3] != 0 ? 1 : 0);
            if (hits.rgba[i + 3] == 0) continue;
            ++count;
            visit(Vec3d(camera.eye_world + Vec3d(hits.rgba[i], hits.rgba[i + 1], hits.rgba[i + 2])),
                  double{image.rgba[i]});
        }
        return count;
    }
};

TEST_F(SolidTextures, StripesAreTheirMeanOverEachPixel) {
    camera = above;
    for (const double scale : {0.173, 0.021, 0.004}) { // 11 pixels, 1.3, a quarter
        SolidTexture solid = black_and_white(Kind::Stripes, scale);
        solid.axis = Vec3d(2, 0, 0);
        const Image image = texture(plane, solid);
        double worst = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const double t = on_plane(x, y).x() / scale;
                const double half = pixel_world / scale / 2;
                worst = std::max(
                    worst, std::abs(image.pixel(x, y)[0] - mean_of_steps(t - half, t + half)));
            }
        // Coordinates of up to 200 periods round by 1.5e-5, which a pixel of 0.09 periods at
        // least divides; hits by 3e-7, a 5000th of a pixel.
        EXPECT_LT(worst, 1.5e-5 / 0.09 + 2e-4 + half_rounding) << scale;
    }
}

TEST_F(SolidTextures, CheckersAreTheirMeanOverEachPixel) {
    camera = above;
    for (const double scale : {0.173, 0.021}) {
        SolidTexture solid = black_and_white(Kind::Checker, scale);
        solid.origin_world = {0.05, 0.02, -0.1 * scale};
        solid.axis = Vec3d::UnitZ();
        const Vec3d across = solid.axis.unitOrthogonal();
        const Vec3d third = solid.axis.cross(across);
        const Image image = texture(plane, solid);
        double worst = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const Vec3d p = on_plane(x, y) - solid.origin_world;
                const double half = pixel_world / scale / 2;
                const auto mean = [&](double t) {
                    return 1 - 2 * mean_of_steps(t - half, t + half);
                };
                const double expected =
                    0.5 - 0.5 * mean(p.dot(across) / scale) * mean(p.dot(third) / scale);
                worst = std::max(worst, std::abs(image.pixel(x, y)[0] - expected));
            }
        EXPECT_LT(worst, 2 * (1.5e-5 / 0.09 + 2e-4) + half_rounding) << scale; // as stripes, twice
    }
}

TEST_F(SolidTextures, StripesAcrossSlantedPixelsAreNearlyTheirMean) {
    camera = above;
    const double scale = 6 * pixel_world;
    SolidTexture solid = black_and_white(Kind::Stripes, scale);
    solid.axis = Vec3d(1, 1.3, 0.4);
    const Image image = texture(plane, solid);
    double worst = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            double sum = 0;
            constexpr int n = 32;
            for (int j = 0; j < n; ++j)
                for (int i = 0; i < n; ++i) {
                    const Vec3d p = on_plane(x, y) + pixel_world * Vec3d((i + 0.5) / n - 0.5,
                                                                         (j + 0.5) / n - 0.5, 0);
                    sum += fraction(p.dot(solid.axis.normalized()) / scale) >= 0.5 ? 1 : 0;
                }
            worst = std::max(worst, std::abs(image.pixel(x, y)[0] - sum / (n * n)));
        }
    // A box instead of a triangle of the same variance: their integrals differ by 0.043 at most, at
    // the box's ends; the brute force by half a row of its samples.
    EXPECT_LT(worst, 0.043 + 0.5 / 32);
}

TEST_F(SolidTextures, StickToTheObjectWhenTheCameraMoves) {
    for (const Kind kind : {Kind::Checker, Kind::Stripes, Kind::Marble, Kind::Wood}) {
        SolidTexture solid = black_and_white(kind, 0.3);
        solid.origin_world = {0.03, 0.04, 0.2};
        camera = above;
        const Image before = texture(plane, solid);
        const Vec3d step(7 * pixel_world, -3 * pixel_world, 0.5);
        camera.eye_world += step;
        camera.target_world += step;
        const Image after = texture(plane, solid);
        double worst = 0;
        for (int y = 3; y < size; ++y)
            for (int x = 0; x + 7 < size; ++x)
                worst = std::max(
                    worst, double{std::abs(after.pixel(x, y - 3)[0] - before.pixel(x + 7, y)[0])});
        // Hits round by 3e-7, a pixel is 0.05 periods: 1e-6/0.3/0.05 where it holds an edge.
        EXPECT_LT(worst, 7e-5 + 2 * half_rounding) << int(kind);
    }
}

TEST_F(SolidTextures, KeepTheirDigitsAMillionAway) {
    const Vec3d far(1e6, -1e6, 3e6);
    std::vector<float> values(static_cast<std::size_t>(torus->extent().sample_count()));
    torus->copy_box(torus->extent(), 0, values);
    GridSpace space = torus->space();
    space.world_from_index.pretranslate(far);
    const auto moved = std::make_shared<DenseField>(space, torus->extent(), values);
    Random random(3);
    DenseField noise_volume = random_dense(random, {Index3::Zero(), Index3::Constant(12)});
    for (const Kind kind : {Kind::Checker, Kind::Stripes, Kind::Marble, Kind::Wood, Kind::Volume}) {
        SolidTexture solid = black_and_white(kind, 0.5);
        const auto volume_at = [&](const Vec3d& p) {
            const std::span<const float> v = noise_volume.values();
            return std::make_shared<DenseField>(GridSpace::uniform(0.3, p), noise_volume.extent(),
                                                std::vector<float>(v.begin(), v.end()));
        };
        camera = {.eye_world = {1.6, 1.2, 4.5}, .target_world = Vec3d::Zero()};
        solid.volume = volume_at(Vec3d::Constant(-1.7));
        const Image near = texture(torus, solid);
        camera.eye_world += far;
        camera.target_world += far;
        solid.volume = volume_at(far + Vec3d::Constant(-1.7));
        // Stripes and checkers of this period are the same there by themselves.
        if (kind != Kind::Stripes && kind != Kind::Checker) solid.origin_world += far;
        const Image same = texture(moved, solid);
        double worst = 0;
        for (std::size_t i = 0; i < near.rgba.size(); ++i)
            worst = std::max(worst, double{std::abs(near.rgba[i] - same.rgba[i])});
        // Hits move by float coordinates of some 24 voxels, 1e-5 of a voxel of 0.075; a pixel of
        // 0.05 periods holds a step.
        EXPECT_LT(worst, 1e-6 / 0.5 / 0.05 + 4 * half_rounding) << int(kind);
    }
}

TEST_F(SolidTextures, MarbleAndWoodAreTheTwins) {
    camera = {.eye_world = {1, 2, 4.5}, .target_world = Vec3d::Zero()};
    for (const Kind kind : {Kind::Marble, Kind::Wood})
        for (const double distance : {0.0, 1e6}) {
            // Wide enough that no pixel but grazing ones loses an octave.
            SolidTexture solid = black_and_white(kind, 3);
            solid.origin_world = {0.3 - distance, 0.1, distance};
            solid.axis = Vec3d(0.2, 1, 0.1);
            const Vec3d axis = solid.axis.normalized();
            const Vec3d across = axis.unitOrthogonal();
            const AnalyticField exact = builtin_field("torus");
            int compared = 0;
            double worst = 0;
            for_each_texel(torus, solid, [&](const Vec3d& p, double share) {
                const Vec3d to_viewer = (camera.eye_world - p).normalized();
                if (exact.jet(p).gradient.dot(to_viewer) < 0.7) return;
                const Vec3d q = (p - solid.origin_world) / 3;
                const Vec3d t(q.dot(across), q.dot(axis.cross(across)), q.dot(axis));
                double expected = 0;
                if (kind == Kind::Marble) {
                    double veins = 0;
                    for (const double f : {1.0, 2.0, 4.0, 8.0}) veins += noise(f * t) / f;
                    expected = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (t.z() + veins));
                } else {
                    expected = fraction(t.head<2>().norm() +
                                        0.4 * noise(t.cwiseProduct(Vec3d(1, 1, 0.25))));
                    if (std::abs(expected - 0.5) > 0.47) return; // near a ring's end
                }
                ++compared;
                worst = std::max(worst, std::abs(share - expected));
            });
            EXPECT_GT(compared, 800);
            // A pixel of 0.015 periods takes pi^2 0.015^2/6 of a wave. Coordinates of 512 round by
            // 3e-5, which eight times the frequency and noise of slope 2 make 2 pi 5e-4.
            EXPECT_LT(worst, 4e-4 + (distance == 0 ? 0 : 3e-3) + half_rounding) << int(kind);
        }
}

TEST_F(SolidTextures, VolumesAreTheTwins) {
    Random random(7);
    const IndexBox extent{Index3(-3, 2, 5), Index3(9, 12, 16)};
    std::vector<float> values(static_cast<std::size_t>(extent.sample_count()));
    for (float& value : values) value = float(random_int(random, 0, 1024)) / 1024; // exact halves
    GridSpace space;
    space.world_from_index.linear() =
        Eigen::AngleAxisd(0.4, Vec3d(1, 2, 3).normalized()).toRotationMatrix() *
        Vec3d(0.2, 0.35, 0.25).asDiagonal();
    // The torus reaches beyond it, where the samples at its border continue.
    space.world_from_index.translation() =
        -(space.world_from_index.linear() * Vec3d(3, 7, 10.5)) + Vec3d(0.3, 0.2, 0);
    const auto volume = std::make_shared<DenseField>(space, extent, values);
    std::vector<Image> images;
    for (const Kernel kernel : {Kernel::BSpline, Kernel::Linear}) {
        SolidTexture solid = black_and_white(Kind::Volume, 1);
        solid.volume = volume;
        solid.volume_filter = kernel == Kernel::BSpline ? "bspline" : "linear";
        double worst = 0;
        int beyond = 0;
        const int count = for_each_texel(torus, solid, [&](const Vec3d& p, double share) {
            const Vec3d p_index = space.to_index(p);
            if (((p_index - extent.lo.cast<double>()).array() < 0).any()) ++beyond;
            worst = std::max(worst, std::abs(share - kernel_value(*volume, p_index, kernel)));
        });
        EXPECT_GT(count, 1000);
        EXPECT_GT(beyond, 100);
        // Hits round by 5e-7, 3e-6 voxels, where slopes are at most 1 along each axis; places in a
        // texture of 12 samples round by 1e-6 each of 8 times.
        // Values from 0 to 1 by fractions of 8 bits, along three axes, where hardware interpolates.
        const double fractions =
            is_software_rasteriser(context->driver().renderer) ? 0 : 3 * 0x1p-9;
        EXPECT_LT(worst, 3 * 3e-6 + 1e-5 + half_rounding + fractions) << int(kernel);
        images.push_back(renderer.read(FrameImage::SolidTexture));
    }
    EXPECT_NE(images[0].rgba, images[1].rgba);
}

TEST_F(SolidTextures, OfAVolumeNeedNoNormals) {
    SolidTexture solid = black_and_white(Kind::Volume, 1);
    solid.volume = torus;
    texture(torus, solid);
    EXPECT_FALSE(pass("gradient").ran);
    EXPECT_EQ(report.look_bytes, 2 * 48 * 48 * 48);
    texture(torus, black_and_white(Kind::Stripes, 1));
    EXPECT_TRUE(pass("gradient").ran);
    EXPECT_EQ(report.look_bytes, 0);
}

TEST_F(SolidTextures, ThatCannotBeAreRefused) {
    Scene scene{.field = torus};
    SolidTexture& solid = scene.look.effects.solid_texture;
    solid = black_and_white(Kind::Volume, 1);
    EXPECT_THROW(renderer.load(scene), InputError);
    solid.volume = sampled(builtin_field("sphere"), gl::max_volume_extent() + 1);
    EXPECT_THROW(renderer.load(scene), InputError);
    solid.volume = torus;
    solid.volume_filter = "cubic";
    EXPECT_THROW(renderer.load(scene), InputError);
    solid = black_and_white(Kind::Wood, 0);
    EXPECT_THROW(renderer.load(scene), InputError);
}

} // namespace
} // namespace isocast::test
