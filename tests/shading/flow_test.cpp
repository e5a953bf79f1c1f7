// Flow along principal directions: on surfaces whose directions are known, under a moving camera.
// SPDX-License-Identifier: MPL-2.0
#include "shading_scene.h"

#include "../volume/random_fields.h"
#include "volume/errors.h"

#include <array>

namespace isocast::test {
namespace {

struct FlowPictures : Shading {
    Image hits;
    Image flow;
    Image noise;

    FlowPictures() { size = 128; }

    /// The effect's images alone: hits, noise, flow.
    void draw_flow(const Scene& scene) {
        renderer.load(scene);
        report = renderer.draw(camera, size, size,
                               {FrameImage::Hit, FrameImage::FlowNoise, FrameImage::Flow});
        hits = renderer.read(FrameImage::Hit);
        flow = renderer.read(FrameImage::Flow);
        noise = renderer.read(FrameImage::FlowNoise);
    }
    std::optional<Vec3d> hit_at(int x, int y) const {
        const float* h = hits.pixel(x, y);
        if (h[3] == 0) return {};
        return camera.eye_world + Vec3d(h[0], h[1], h[2]);
    }
    /// From the top left.
    Eigen::Vector2d pixel_of(const Vec3d& p_world) const {
        const Vec3d v = camera.view_from_world_rotation() * (p_world - camera.eye_world);
        const double scale = size / (2 * camera.half_height_at(-v.z()));
        return {size / 2.0 + scale * v.x(), size / 2.0 - scale * v.y()};
    }
};

Scene scene_of(const AnalyticField& field, int samples = 48) {
    return {.field = sampled(field, samples)};
}

const AnalyticField torus = builtin_field("torus"); // radii 1 and 0.4, about z

/// Unit, around the tube (the first principal direction), and around the axis.
Vec3d parallel_at(const Vec3d& p) {
    return Vec3d(-p.y(), p.x(), 0).normalized();
}
Vec3d meridian_at(const Vec3d& p) {
    return torus.jet(p).gradient.cross(parallel_at(p)).normalized();
}

/// The picture's variation along a direction of the surface, by that across it in the picture; over
/// pixels whose neighbours are all on lines.
template<class Direction>
double variation_along(const FlowPictures& pictures, Direction direction) {
    double along = 0;
    double across = 0;
    int count = 0;
    for (int y = 1; y + 1 < pictures.size; ++y)
        for (int x = 1; x + 1 < pictures.size; ++x) {
            const auto p = pictures.hit_at(x, y);
            const std::array around{pictures.flow.pixel(x - 1, y), pictures.flow.pixel(x + 1, y),
                                    pictures.flow.pixel(x, y - 1), pictures.flow.pixel(x, y + 1)};
            if (!p || std::ranges::any_of(around, [](const float* f) { return f[3] < 0.9F; }))
                continue;
            ++count;
            const Eigen::Vector2d slope(around[1][0] - around[0][0], around[3][0] - around[2][0]);
            const Eigen::Vector2d line =
                (pictures.pixel_of(*p + 1e-4 * direction(*p)) - pictures.pixel_of(*p)).normalized();
            along += std::pow(slope.dot(line), 2);
            across += std::pow(slope.x() * line.y() - slope.y() * line.x(), 2);
        }
    EXPECT_GT(count, 1000);
    return along / across;
}

TEST_F(FlowPictures, FollowTheMeridiansOfATorusOrItsParallels) {
    Scene scene = scene_of(torus);
    for (const bool is_parallel_projection : {false, true}) {
        if (is_parallel_projection) {
            camera.projection = Projection::Orthographic;
            camera.height_world = 3;
        }
        scene.look.effects.flow = {.direction = 1};
        draw_flow(scene);
        // A line of 20 pixels hardly changes from one to the next, where grains of 1.5 do: the
        // window's slope is at most pi/20 of it. A picture without lines has 1.
        EXPECT_LT(variation_along(*this, meridian_at), 0.1);
        EXPECT_GT(variation_along(*this, parallel_at), 5);
        scene.look.effects.flow = {.direction = 2};
        draw_flow(scene);
        EXPECT_LT(variation_along(*this, parallel_at), 0.1);
        EXPECT_GT(variation_along(*this, meridian_at), 5);
    }
}

TEST_F(FlowPictures, FollowTheMeridiansWhereVoxelsAreNoCubes) {
    GridSpace space;
    space.world_from_index.linear() =
        Eigen::AngleAxisd(0.4, Vec3d(1, 2, 3).normalized()).toRotationMatrix() *
        Vec3d(0.07, 0.09, 0.11).asDiagonal();
    const IndexBox extent{Index3::Constant(-26), Index3::Constant(27)};
    std::vector<float> values;
    for_each_sample(extent, [&](const Index3& i) {
        values.push_back(static_cast<float>(torus.jet(space.to_world(i.cast<double>())).value));
    });
    Scene scene{.field = std::make_shared<DenseField>(space, extent, std::move(values))};
    draw_flow(scene);
    EXPECT_LT(variation_along(*this, meridian_at), 0.1);
}

/// The torus of the other tests with a cylinder through its hole, of another grid.
TEST_F(FlowPictures, FollowEachOfTheObjects) {
    Scene scene{.objects = {{.field = sampled(torus, 48)},
                            {.field = sampled(builtin_field("cylinder"), 41)}}};
    draw_flow(scene);
    int on_cylinder = 0;
    for (std::size_t i = 0; i < hits.rgba.size(); i += 4)
        if (hits.rgba[i + 3] == 2) {
            on_cylinder += flow.rgba[i + 3] > 0.9F ? 1 : 0;
            // The torus is taken alone: lines end where it does.
            flow.rgba[i + 3] = 0;
        }
    EXPECT_GT(on_cylinder, 300);
    EXPECT_LT(variation_along(*this, meridian_at), 0.1);
}

struct Correlation {
    double sum = 0, sum_a = 0, sum_b = 0, sum_aa = 0, sum_bb = 0, sum_ab = 0;
    void add(double a, double b) {
        sum += 1;
        sum_a += a;
        sum_b += b;
        sum_aa += a * a;
        sum_bb += b * b;
        sum_ab += a * b;
    }
    double value() const {
        const double cov = sum * sum_ab - sum_a * sum_b;
        return cov / std::sqrt((sum * sum_aa - sum_a * sum_a) * (sum * sum_bb - sum_b * sum_b));
    }
};

TEST_F(FlowPictures, StickToTheSurfaceWhenTheCameraMoves) {
    Scene scene = scene_of(torus);
    scene.look.effects.flow = {.length_pixels = 12, .grain_pixels = 3};
    draw_flow(scene);
    const FlowPictures* now = this;
    const Image old_noise = noise;
    const Image old_flow = flow;
    const Image old_hits = hits;
    const Vec3d old_eye = camera.eye_world;
    camera.eye_world = Eigen::AngleAxisd(0.3, Vec3d::UnitY()) * camera.eye_world;
    draw_flow(scene);
    Correlation of_noise;
    Correlation of_flow;
    Correlation of_screen;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const float* h = old_hits.pixel(x, y);
            if (h[3] == 0) continue;
            const Vec3d p = old_eye + Vec3d(h[0], h[1], h[2]);
            const Eigen::Vector2d to = now->pixel_of(p);
            const int i = static_cast<int>(std::floor(to.x()));
            const int j = static_cast<int>(std::floor(to.y()));
            if (i < 0 || j < 0 || i >= size || j >= size) continue;
            const auto seen = now->hit_at(i, j);
            // A pixel is 0.019 wide here, and half of one is how far the nearest pixel is; of
            // surfaces that are seen at less than 60 degrees.
            if (!seen || (*seen - p).norm() > 0.019 * 2) continue;
            const Vec3d to_eye = (camera.eye_world - p).normalized();
            if (torus.jet(p).gradient.dot(to_eye) < 0.5) continue;
            of_noise.add(old_noise.pixel(x, y)[0], noise.pixel(i, j)[0]);
            if (old_flow.pixel(x, y)[3] > 0.9F && flow.pixel(i, j)[3] > 0.9F) {
                of_flow.add(old_flow.pixel(x, y)[0], flow.pixel(i, j)[0]);
                of_screen.add(old_flow.pixel(x, y)[0], flow.pixel(x, y)[0]);
            }
        }
    EXPECT_GT(of_flow.sum, 2000);
    // Noise of grains of 3 pixels, up to half a pixel off on either axis: (1 - 0.17)^2 on average,
    // and less where the grain changed. Lines are sharper across.
    EXPECT_GT(of_noise.value(), 0.6);
    EXPECT_GT(of_flow.value(), 0.5);
    // Some 80 independent lines: 0.11, three times that.
    EXPECT_LT(std::abs(of_screen.value()), 0.33);
}

/// Twin of shaders/shading/flow/flow_noise.frag, in double.
double lattice_noise(const Vec3d& p_cells, int octave) {
    const Vec3d below = p_cells.array().floor();
    const Vec3d a = p_cells - below;
    double sum = 0;
    double variance = 1;
    for (int i = 0; i < 8; ++i) {
        std::array<std::uint32_t, 3> v{};
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const int corner = i >> axis & 1;
            weight *= corner == 1 ? a[axis] : 1 - a[axis];
            const auto k = static_cast<std::size_t>(axis);
            v[k] = static_cast<std::uint32_t>(static_cast<std::int64_t>(below[axis]) + corner +
                                              octave);
            v[k] = v[k] * 1664525U + 1013904223U;
        }
        v[0] += v[1] * v[2];
        v[1] += v[2] * v[0];
        v[2] += v[0] * v[1];
        for (std::uint32_t& bits : v) bits ^= bits >> 16;
        v[0] += v[1] * v[2];
        sum += weight * (double(v[0] >> 8) * 0x1p-23 - 1);
    }
    for (int axis = 0; axis < 3; ++axis)
        variance *= (a[axis] * a[axis] + (1 - a[axis]) * (1 - a[axis]));
    return sum * std::sqrt(3 / variance);
}

/// p  from the field's sample 0
double noise_at(const Vec3d& p, double grain) {
    const double level = std::log2(grain);
    const int octave = static_cast<int>(std::floor(level));
    const double a = level - octave;
    return ((1 - a) * lattice_noise(p * std::exp2(-octave), octave) +
            a * lattice_noise(p * std::exp2(-octave - 1), octave + 1)) /
           std::sqrt(a * a + (1 - a) * (1 - a));
}

TEST_F(FlowPictures, HaveTheTwinsNoiseHoweverFarFromTheOrigin) {
    for (const double away : {0.0, 3e6}) {
        const Vec3d offset(away, -away, 0.3 * away);
        const GridSpace space = GridSpace::uniform(0.1, offset - Vec3d::Constant(2));
        const IndexBox extent{Index3::Zero(), Index3::Constant(41)};
        std::vector<float> values;
        for_each_sample(extent, [&](const Index3& i) {
            values.push_back(
                static_cast<float>(torus.jet(space.to_world(i.cast<double>()) - offset).value));
        });
        Scene scene{.field = std::make_shared<DenseField>(space, extent, std::move(values))};
        scene.look.effects.flow = {.grain_pixels = 2.7};
        for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
            camera = {.eye_world = offset + Vec3d(1.6, 1.2, 4.5),
                      .target_world = offset,
                      .projection = projection,
                      .height_world = 3};
            renderer.load(scene);
            report = renderer.draw(camera, size, size, {FrameImage::Hit, FrameImage::FlowNoise});
            EXPECT_FALSE(pass("direction").ran);
            hits = renderer.read(FrameImage::Hit);
            noise = renderer.read(FrameImage::FlowNoise);
            const Vec3d forward = -camera.view_from_world_rotation().row(2).transpose();
            int count = 0;
            double squares = 0;
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) {
                    const float* h = hits.pixel(x, y);
                    if (h[3] == 0) {
                        EXPECT_EQ(noise.pixel(x, y)[0], 0);
                        continue;
                    }
                    ++count;
                    const Vec3d from_eye(h[0], h[1], h[2]);
                    const double depth =
                        projection == Projection::Perspective ? from_eye.dot(forward) : 1;
                    const double grain = 2.7 * 2 * camera.half_height_at(depth) / size;
                    const Vec3d eye = camera.eye_world - space.world_from_index.translation();
                    const double expected = noise_at(eye + from_eye, grain);
                    // Positions of up to 200 cells round by 2^-17 of one; the noise's slope is at
                    // most 2 sqrt 3 sqrt 27 a cell, its octaves' shares change by less, and offsets
                    // of 3e6 in double by 5e-10.
                    ASSERT_NEAR(noise.pixel(x, y)[0], expected, 18 * 3 * 0x1p-17);
                    squares += expected * expected;
                }
            EXPECT_GT(count, 3000);
            // Some 500 independent grains: 0.06 of the variance, three times that.
            EXPECT_NEAR(squares / count, 1, 0.2);
        }
    }
}

/// Along a cylinder's axis, which is z, the picture moves to the side of larger z.
TEST_F(FlowPictures, TravelAlongTheLinesAndComeBack) {
    camera = {.eye_world = {4, 0, 0},
              .target_world = Vec3d::Zero(),
              .projection = Projection::Orthographic,
              .height_world = 1.6};
    Scene scene = scene_of(builtin_field("cylinder"), 32);
    const auto picture = [&](double phase) {
        scene.look.effects.flow = {.direction = 2, .length_pixels = 40, .phase = phase};
        draw_flow(scene);
        return flow;
    };
    const Image at_0 = picture(0);
    const Image at_1 = picture(1);
    const Image at_half = picture(0.5);
    const Image at_tenth = picture(0.1);
    Correlation of_half;
    for (std::size_t i = 0; i < at_0.rgba.size(); i += 4) {
        ASSERT_NEAR(at_0.rgba[i], at_1.rgba[i], 1e-5); // cosines of 2 pi and of 0
        of_half.add(at_0.rgba[i], at_half.rgba[i]);
    }
    EXPECT_LT(of_half.value(), 0.6);
    // z runs to the left of this camera or to its right.
    const int left = pixel_of({0.5, 0, 0.1}).x() < pixel_of({0.5, 0, 0}).x() ? 1 : -1;
    const auto shifted_by = [&](int pixels) {
        Correlation c;
        for (int y = size / 4; y < size * 3 / 4; ++y)
            for (int x = size / 4; x < size * 3 / 4; ++x)
                c.add(at_0.pixel(x, y)[0], at_tenth.pixel(x - left * pixels, y)[0]);
        return c.value();
    };
    // The ripple of 20 pixels moves by a tenth of that, within a window that stays.
    EXPECT_GT(shifted_by(1), shifted_by(0));
    EXPECT_GT(shifted_by(0), shifted_by(-1) + 0.05);
}

TEST_F(FlowPictures, AreGoneAtStrengthZero) {
    Scene scene = scene_of(torus);
    const Image plain = draw(scene);
    const FrameReport without = report;
    for (const PassReport& p : without.passes)
        EXPECT_EQ(p.ran, p.name == "raycast" || p.name == "gradient" || p.name == "shading");
    scene.look.effects.flow = {.strength = 0, .direction = 2, .length_pixels = 99};
    EXPECT_EQ(draw(scene).rgba, plain.rgba);
    EXPECT_EQ(report.programs_compiled, without.programs_compiled);
    EXPECT_EQ(report.image_bytes, without.image_bytes);
    scene.look.effects.flow.strength = 0.5;
    EXPECT_NE(draw(scene).rgba, plain.rgba);
    EXPECT_EQ(report.programs_compiled, without.programs_compiled + 4); // with shading's
    scene.look.effects.flow.strength = 0;
    EXPECT_EQ(draw(scene).rgba, plain.rgba);
    EXPECT_EQ(report.image_bytes, without.image_bytes);
}

TEST_F(FlowPictures, AloneShadeNothing) {
    Scene scene = scene_of(torus);
    draw(scene, FrameImage::Flow);
    for (const PassReport& p : report.passes)
        EXPECT_EQ(p.ran, p.name == "raycast" || p.name == "direction" || p.name == "flow noise" ||
                             p.name == "flow")
            << p.name;
    EXPECT_EQ(report.programs_compiled, 4);
    // Hits, directions and flow of four floats, noise of one.
    EXPECT_EQ(report.image_bytes, (3 * 16 + 4) * size * size);
}

TEST_F(FlowPictures, AreTheSameTwice) {
    const Scene scene = scene_of(torus);
    draw_flow(scene);
    const Image first = flow;
    draw_flow(scene);
    EXPECT_EQ(flow.rgba, first.rgba);
}

TEST_F(FlowPictures, KeepTheMeanColour) {
    draw_flow(scene_of(torus));
    double sum = 0;
    double squares = 0;
    int count = 0;
    for (std::size_t i = 0; i < flow.rgba.size(); i += 4) {
        if (flow.rgba[i + 3] < 0.9F) continue;
        ++count;
        sum += flow.rgba[i] - 1;
        squares += std::pow(flow.rgba[i] - 1, 2);
    }
    EXPECT_GT(count, 3000);
    // Lines of 20 pixels, 1.5 wide: some 100 independent ones of a deviation of 0.3.
    EXPECT_NEAR(sum / count, 0, 0.1);
    EXPECT_NEAR(std::sqrt(squares / count), 0.3, 0.1);
}

TEST_F(FlowPictures, HaveNoLinesOnASphere) {
    draw_flow(scene_of(builtin_field("sphere")));
    int count = 0;
    for (std::size_t i = 0; i < flow.rgba.size(); i += 4) {
        if (hits.rgba[i + 3] == 0) continue;
        ++count;
        // The spline's curvatures differ by up to 1 % of themselves there: of the 10 % at which
        // lines are whole, smoothstep makes 3 % of a tenth.
        EXPECT_LT(flow.rgba[i + 3], 0.03);
    }
    EXPECT_GT(count, 3000);
}

TEST_F(FlowPictures, AreFiniteOnNoiseFromInsideAndAlongEveryDirection) {
    Random random(7);
    const auto noisy =
        std::make_shared<DenseField>(random_dense(random, {Index3::Zero(), Index3::Constant(24)}));
    const std::array cameras{Camera{.eye_world = {60, 50, 70}, .target_world = {12, 12, 12}},
                             Camera{.eye_world = {12.3, 11.9, 12.1}, .target_world = {0, 3, 1}},
                             Camera{.eye_world = {12, 12, 60},
                                    .target_world = {12, 12, 12},
                                    .projection = Projection::Orthographic,
                                    .height_world = 30}};
    for (const Camera& c : cameras)
        for (const int direction : {1, 2})
            // At half a period the ripple is zero in the kernel's middle.
            for (const std::optional<double> phase : {std::optional<double>{}, {0.3}, {0.5}}) {
                camera = c;
                Scene scene{.field = noisy};
                scene.look.effects.flow = {.direction = direction, .phase = phase};
                draw_flow(scene);
                int count = 0;
                for (std::size_t i = 0; i < flow.rgba.size(); i += 4) {
                    count += hits.rgba[i + 3] != 0;
                    ASSERT_TRUE(flow.rgba[i] >= 0.0999F && flow.rgba[i] <= 1.9001F); // the clamp's
                    ASSERT_TRUE(flow.rgba[i + 3] >= 0 && flow.rgba[i + 3] <= 1);
                    ASSERT_TRUE(hits.rgba[i + 3] != 0 || flow.rgba[i + 3] == 0);
                }
                EXPECT_GT(count, 2000);
            }
}

TEST_F(FlowPictures, OfImpossibleKindsAreRefused) {
    Scene scene = scene_of(torus);
    for (const Flow& flow_kind : {Flow{.direction = 3}, Flow{.length_pixels = 0},
                                  Flow{.length_pixels = 1e9}, Flow{.grain_pixels = -1}}) {
        scene.look.effects.flow = flow_kind;
        EXPECT_THROW(renderer.load(scene), InputError);
    }
}

} // namespace
} // namespace isocast::test
