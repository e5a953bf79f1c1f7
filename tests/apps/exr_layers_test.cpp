// SPDX-License-Identifier: MPL-2.0
#include "apps/exr_layers.h"

#include "apps/inputs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace isocast::test {
namespace {

constexpr int width = 12, height = 7;

/// A frame whose pixel (x, y) hits at t = 3 + x along its ray, but for the first, which misses.
FrameImages made_frame(const Camera& camera) {
    const Image black{width, height, std::vector<float>(std::size_t{4} * width * height)};
    FrameImages frame;
    std::vector<float>& beauty = (frame[FrameImage::Beauty] = black).rgba;
    std::vector<float>& hits = (frame[FrameImage::Hit] = black).rgba;
    std::vector<float>& gradients = (frame[FrameImage::Gradient] = black).rgba;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t i = 4 * static_cast<std::size_t>(y * width + x);
            if (i == 0) continue;
            for (std::size_t c = 0; c < 3; ++c) beauty[i + c] = float(x) / 16 + float(c) / 4;
            const Ray ray = camera_ray(camera, width, height, x + 0.5, y + 0.5);
            const Vec3d hit = ray.origin_world + (3 + x) * ray.direction_world - camera.eye_world;
            const Vec3d gradient = Vec3d(1 + x, -2, y);
            for (std::size_t c = 0; c < 3; ++c) {
                hits[i + c] = static_cast<float>(hit[static_cast<int>(c)]);
                gradients[i + c] = static_cast<float>(gradient[static_cast<int>(c)]);
            }
            beauty[i + 3] = hits[i + 3] = gradients[i + 3] = 1;
        }
    return frame;
}

class ExrLayersOf : public testing::TestWithParam<Projection> {
protected:
    Camera camera{.eye_world = {1, 2, 30},
                  .target_world = {-4, 3, 1},
                  .up = {0.2, 1, 0},
                  .projection = GetParam(),
                  .fov_y_degrees = 40,
                  .height_world = 9};
    FrameImages frame = made_frame(camera);
    ExrImage exr = exr_image(frame, camera, {.position = true, .normal = true});

    float value(const std::string& channel, int x, int y) const {
        return exr.channels.at(channel).values.at(static_cast<std::size_t>(y * width + x));
    }
    Vec3d vector(const std::string& layer, int x, int y) const {
        return {value(layer + ".X", x, y), value(layer + ".Y", x, y), value(layer + ".Z", x, y)};
    }
};

INSTANTIATE_TEST_SUITE_P(Both, ExrLayersOf,
                         testing::Values(Projection::Perspective, Projection::Orthographic));

TEST_P(ExrLayersOf, NdcMatrixTakesPositionsToTheirPixels) {
    for (int y = 0; y < height; ++y)
        for (int x = y == 0 ? 1 : 0; x < width; ++x) {
            const Eigen::Vector4d clip =
                exr.matrices.at("worldToNDC").cast<double>() * vector("P", x, y).homogeneous();
            // 1e-5: float32 positions near 40 have steps of 4e-6, and the picture's half is 4.5
            // high; the float32 matrix adds as much again.
            EXPECT_NEAR(clip.x() / clip.w(), 2 * (x + 0.5) / width - 1, 1e-5);
            EXPECT_NEAR(clip.y() / clip.w(), 1 - 2 * (y + 0.5) / height, 1e-5);
        }
}

TEST_P(ExrLayersOf, DepthIsTheCameraSpaceDistanceAlongTheAxis) {
    for (int y = 0; y < height; ++y)
        for (int x = y == 0 ? 1 : 0; x < width; ++x) {
            const Eigen::Vector4d p =
                exr.matrices.at("worldToCamera").cast<double>() * vector("P", x, y).homogeneous();
            EXPECT_NEAR(value("Z", x, y), -p.z(), 2e-5); // float32 at 40, a few roundings
            // camera_ray's direction has length 1 along the axis for both projections.
            EXPECT_NEAR(value("Z", x, y), 3 + x, 2e-5);
        }
}

TEST_P(ExrLayersOf, NormalsAreUnitGradients) {
    for (int y = 0; y < height; ++y)
        for (int x = y == 0 ? 1 : 0; x < width; ++x)
            // 1e-7: float32 below 1.
            EXPECT_LT((vector("N", x, y) - Vec3d(1 + x, -2, y).normalized()).norm(), 2e-7);
}

TEST_P(ExrLayersOf, MissesAreInfinitelyFarAndEmpty) {
    EXPECT_TRUE(std::isinf(value("Z", 0, 0)));
    EXPECT_EQ(vector("P", 0, 0), Vec3d::Zero());
    EXPECT_EQ(vector("N", 0, 0), Vec3d::Zero());
    for (const char* name : {"R", "G", "B", "A"}) EXPECT_EQ(value(name, 0, 0), 0);
}

TEST_P(ExrLayersOf, ColourIsHalfAndTheRestFloat) {
    for (const auto& [name, channel] : exr.channels)
        EXPECT_EQ(channel.as_half, name.size() == 1 && name != "Z") << name;
    EXPECT_EQ(value("G", 4, 2), frame.at(FrameImage::Beauty).pixel(4, 2)[1]);
    EXPECT_EQ(value("A", 4, 2), 1);
}

TEST_P(ExrLayersOf, OnlyTheLayersAskedForExist) {
    const ExrImage plain = exr_image(frame, camera, {});
    std::vector<std::string> names;
    for (const auto& [name, channel] : plain.channels) names.push_back(name);
    EXPECT_EQ(names, (std::vector<std::string>{"A", "B", "G", "R", "Z"}));
}

TEST_P(ExrLayersOf, CurvaturesOfKnownShapes) {
    struct Shape {
        float k1, k2;
        double mean, gauss, index, curvedness;
    };
    // A sphere, a hollow one, a cylinder, a saddle, a plane.
    constexpr std::array shapes{Shape{2, 2, 2, 4, 1, 2}, Shape{-3, -3, -3, 9, -1, 3},
                                Shape{2, 0, 1, 0, 0.5, std::numbers::sqrt2},
                                Shape{1, -1, 0, -1, 0, 1}, Shape{0, 0, 0, 0, 0, 0}};
    Image& curvatures = frame[FrameImage::Curvature];
    curvatures = {width, height, std::vector<float>(std::size_t{4} * width * height)};
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        float* pixel = &curvatures.rgba[4 * (i + 1)]; // the first is a miss
        pixel[0] = shapes[i].k1;
        pixel[1] = shapes[i].k2;
        pixel[3] = float(1 + i % 3);
    }
    exr = exr_image(frame, camera, {.curvature = true});
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const int x = static_cast<int>(i) + 1;
        EXPECT_EQ(value("curvature.k1", x, 0), shapes[i].k1);
        EXPECT_EQ(value("curvature.k2", x, 0), shapes[i].k2);
        EXPECT_EQ(value("curvature.mean", x, 0), shapes[i].mean);
        EXPECT_EQ(value("curvature.gauss", x, 0), shapes[i].gauss);
        EXPECT_FLOAT_EQ(value("curvature.shapeIndex", x, 0), static_cast<float>(shapes[i].index));
        EXPECT_FLOAT_EQ(value("curvature.curvedness", x, 0),
                        static_cast<float>(shapes[i].curvedness));
        EXPECT_EQ(value("curvature.flag", x, 0), 1 + i % 3);
    }
    for (const char* name : {"k1", "curvedness", "flag"})
        EXPECT_EQ(value(std::string("curvature.") + name, 0, 0), 0) << "a miss";
}

TEST_P(ExrLayersOf, DirectionsAreAFrameWithTheNormal) {
    Image& directions = frame[FrameImage::Direction];
    directions = frame.at(FrameImage::Gradient);
    for (std::size_t i = 4; i < directions.rgba.size(); i += 4) {
        // Across the gradient (1 + x, -2, y).
        const Vec3d g(directions.rgba[i], directions.rgba[i + 1], directions.rgba[i + 2]);
        const Vec3d t = g.cross(Vec3d::UnitY()).normalized();
        for (std::size_t c = 0; c < 3; ++c)
            directions.rgba[i + c] = static_cast<float>(t[static_cast<int>(c)]);
    }
    exr = exr_image(frame, camera, {.normal = true, .directions = true});
    for (int y = 0; y < height; ++y)
        for (int x = y == 0 ? 1 : 0; x < width; ++x) {
            const Vec3d n = vector("N", x, y);
            const Vec3d t1 = vector("T1", x, y);
            const Vec3d t2 = vector("T2", x, y);
            // 3e-7: float32 below 1, a few roundings.
            EXPECT_LT((t1.cross(t2) - n).norm(), 3e-7);
            EXPECT_NEAR(t1.dot(t2), 0, 3e-7);
        }
    EXPECT_EQ(vector("T1", 0, 0), Vec3d::Zero());
    EXPECT_EQ(vector("T2", 0, 0), Vec3d::Zero());
}

TEST_P(ExrLayersOf, SharesAndNumbersAreZeroOnMisses) {
    frame[FrameImage::Occlusion] = frame[FrameImage::Shadow] = frame.at(FrameImage::Hit);
    std::ranges::fill(frame[FrameImage::Occlusion].rgba, 0.25F);
    std::ranges::fill(frame[FrameImage::Shadow].rgba, 0.75F);
    exr = exr_image(frame, camera, {.occlusion = true, .shadow = true, .id = true});
    EXPECT_EQ(value("AO.Y", 3, 2), 0.25F);
    EXPECT_EQ(value("shadow.Y", 3, 2), 0.75F);
    EXPECT_EQ(value("id", 3, 2), 1);
    // Where a second object was taken away.
    frame.at(FrameImage::Hit).rgba[4 * (2 * width + 3) + 3] = -2;
    EXPECT_EQ(exr_image(frame, camera, {.id = true}).channels.at("id").values.at(2 * width + 3), 2);
    for (const char* name : {"AO.Y", "shadow.Y", "id"}) EXPECT_EQ(value(name, 0, 0), 0) << name;
}

TEST_P(ExrLayersOf, StepsAreThoseOfMissesToo) {
    std::ranges::fill((frame[FrameImage::Steps] = frame.at(FrameImage::Hit)).rgba, 7);
    exr = exr_image(frame, camera, {.steps = true});
    EXPECT_EQ(value("debug.steps", 0, 0), 7);
    EXPECT_EQ(value("debug.steps", 3, 2), 7);
}

TEST_P(ExrLayersOf, RowsOfAPictureHaveTheWholeOnesMatrices) {
    FrameImages rows = frame;
    for (auto& [image, pixels] : rows) {
        pixels.height = 2;
        pixels.rgba.resize(std::size_t{4} * 2 * width);
    }
    const ExrImage part = exr_image(rows, camera, {}, double(width) / height);
    EXPECT_EQ(part.matrices.at("worldToNDC"), exr.matrices.at("worldToNDC"));
}

TEST_P(ExrLayersOf, ColourIsLeftOutWhereNothingWasShaded) {
    frame.erase(FrameImage::Beauty);
    const ExrImage plain = exr_image(frame, camera, {.id = true});
    EXPECT_EQ(plain.channels.size(), 2u);
    EXPECT_TRUE(plain.channels.contains("Z") && plain.channels.contains("id"));
}

TEST(ExrLayers, AreNamedInAList) {
    EXPECT_TRUE(exr_layers_from("P").position);
    EXPECT_FALSE(exr_layers_from("P").normal);
    EXPECT_TRUE(exr_layers_from("N,P").position && exr_layers_from("N,P").normal);
    EXPECT_TRUE(exr_layers_from("P,curvature").curvature);
    EXPECT_TRUE(exr_layers_from("T,AO,shadow,id").directions);
    EXPECT_TRUE(exr_layers_from("T,AO,shadow,id").id);
    EXPECT_TRUE(exr_layers_from("steps").steps);
    for (const char* text : {"", "P,", "Q", "P N", "p"})
        EXPECT_THROW(exr_layers_from(text), UsageError) << text;
}

} // namespace
} // namespace isocast::test
