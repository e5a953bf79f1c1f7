// Curvatures as colours on shapes whose curvatures are known.
// SPDX-License-Identifier: MPL-2.0
#include "shading_scene.h"

#include "raycaster/effects/colour_maps.h"
#include "raycaster/effects/curvature_map.h"
#include "raycaster/effects/curvature_measure.h"
#include "volume/errors.h"

#include <numbers>

namespace isocast::test {
namespace {

/// The layers' texels are halves, which software GLs cut off, and so are pictures'.
constexpr double half_rounding = 2.0 / 2048;

double srgb(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double greatest_difference(const Vec3d& a, const Vec3d& b) {
    return (a - b).cwiseAbs().maxCoeff();
}

Vec3d rgb(const float* pixel) {
    return {pixel[0], pixel[1], pixel[2]};
}

TEST(ColourMaps, AreThePublishedOnes) {
    const auto difference = [](ColourMap map, double t, const Vec3d& published) {
        return greatest_difference(colour_of(map, t).unaryExpr(&srgb), published);
    };
    // Rows of the published table; the first two are among ours.
    using enum ColourMap;
    EXPECT_LT(difference(Viridis, 0, {0.267004, 0.004874, 0.329415}), 1e-6);
    EXPECT_LT(difference(Viridis, 1, {0.993248, 0.906157, 0.143936}), 1e-6);
    EXPECT_LT(difference(Viridis, 16 / 255.0, {0.282327, 0.094955, 0.417331}), 0.004);
    EXPECT_LT(difference(Viridis, 64 / 255.0, {0.229739, 0.322361, 0.545706}), 0.004);
    EXPECT_LT(difference(Viridis, 128 / 255.0, {0.127568, 0.566949, 0.550556}), 0.004);
    EXPECT_LT(difference(Viridis, 223 / 255.0, {0.668054, 0.861999, 0.196293}), 0.004);
    EXPECT_LT(difference(Viridis, 247 / 255.0, {0.916242, 0.896091, 0.100717}), 0.02);
    // Bytes of Moreland's table of 33; its ends in Msh are rounded to two digits.
    EXPECT_LT(difference(CoolWarm, 0, Vec3d(59, 76, 192) / 255), 1.5 / 255);
    EXPECT_LT(difference(CoolWarm, 0.25, Vec3d(141, 176, 254) / 255), 1.5 / 255);
    EXPECT_LT(difference(CoolWarm, 0.5, Vec3d(221, 221, 221) / 255), 1.5 / 255);
    EXPECT_LT(difference(CoolWarm, 0.75, Vec3d(244, 154, 123) / 255), 1.5 / 255);
    EXPECT_LT(difference(CoolWarm, 1, Vec3d(180, 4, 38) / 255), 1.5 / 255);
}

TEST(CurvatureMeasures, OfKnownShapesAreKnown) {
    using enum CurvatureMeasure;
    EXPECT_EQ(curvature_measure(ShapeIndex, 2, 2), 1);   // ball
    EXPECT_EQ(curvature_measure(ShapeIndex, 3, 0), 0.5); // ridge
    EXPECT_EQ(curvature_measure(ShapeIndex, 3, -3), 0);  // saddle
    EXPECT_EQ(curvature_measure(ShapeIndex, 0, -3), -0.5);
    EXPECT_EQ(curvature_measure(ShapeIndex, -2, -2), -1); // cup
    EXPECT_EQ(curvature_measure(ShapeIndex, 0, 0), 0);
    EXPECT_EQ(curvature_measure(Gauss, 3, -2), -6);
    EXPECT_EQ(curvature_measure(Mean, 3, -2), 0.5);
    EXPECT_NEAR(curvature_measure(Curvedness, 2, 2), 2, 1e-15); // a few roundings
}

TEST(CurvatureMaps, GiveEachShapeAColourOfItsOwn) {
    const std::vector<Vec3d> shapes{builtin_curvature_map(1, 1),   builtin_curvature_map(1, 0),
                                    builtin_curvature_map(1, -1),  builtin_curvature_map(0, -1),
                                    builtin_curvature_map(-1, -1), builtin_curvature_map(0, 0)};
    for (std::size_t i = 0; i < shapes.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            EXPECT_GT(greatest_difference(shapes[i], shapes[j]), 0.25); // a glance tells them apart
    EXPECT_EQ(builtin_curvature_map(0.3, -0.2), builtin_curvature_map(-0.2, 0.3));
}

struct CurvatureEffects : Shading {
    const std::shared_ptr<const FieldSource> plane = sampled(
        {"plane",
         [](const Vec3d& p) {
             const Vec3d normal(0.48, 0.6, 0.64);
             return Jet{.value = normal.dot(p), .gradient = normal, .hessian = Mat3d::Zero()};
         },
         1},
        32);
    const std::shared_ptr<const FieldSource> torus = sampled(builtin_field("torus"), 64);
    static constexpr double major = 1;
    static constexpr double minor = 0.4;
    // Of the interpolating spline's Hessian on a circle of 7.2 voxels of 0.0556: 1/12 of fourth
    // derivatives, 15/7.2^3, over the voxel (tests/raycaster: CurvatureImages).
    static constexpr double curvature_error = 15 / 12.0 / (7.2 * 7.2 * 7.2) / 0.0556;

    /// Calls visit(pixel, k1, k2), the exact ones, for each hit on the torus.
    template<class Visit>
    void for_each_texel(const Scene& scene, FrameImage image, Visit visit) {
        renderer.load(scene);
        report = renderer.draw(camera, size, size, {FrameImage::Hit, image});
        const Image hits = renderer.read(FrameImage::Hit);
        const Image texels = renderer.read(image);
        int count = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            if (hits.rgba[i + 3] == 0) {
                EXPECT_EQ(texels.rgba[i + 3], 0);
                continue;
            }
            ++count;
            const Vec3d p =
                camera.eye_world + Vec3d(hits.rgba[i], hits.rgba[i + 1], hits.rgba[i + 2]);
            const double cosine = (p.head<2>().norm() - major) / minor; // about z
            visit(&texels.rgba[i], 1 / minor, cosine / (major + minor * cosine));
        }
        EXPECT_GT(count, 1000);
    }
};

TEST_F(CurvatureEffects, ColoursOfATorusAreThoseOfItsCurvatures) {
    using enum CurvatureMeasure;
    const std::map<CurvatureMeasure, std::array<double, 2>> ranges{
        {K1, {0, 4}},     {K2, {-2, 2}},         {Mean, {-3, 3}},
        {Gauss, {-5, 5}}, {ShapeIndex, {-1, 1}}, {Curvedness, {1, 3}}};
    for (const auto& [measure, range] : ranges)
        for (const ColourMap map : {ColourMap::Viridis, ColourMap::CoolWarm}) {
            Scene scene{.field = torus};
            scene.look.effects.curvature_colour = {
                .strength = 1, .measure = measure, .map = map, .range = range};
            double worst = 0; // beyond what the curvatures' errors explain
            for_each_texel(
                scene, FrameImage::CurvatureColour, [&](const float* pixel, double k1, double k2) {
                    const auto place = [&](double a, double b) {
                        const double value = curvature_measure(measure, k1 + a, k2 + b);
                        return std::clamp((value - range[0]) / (range[1] - range[0]), 0.0, 1.0);
                    };
                    const Vec3d expected = colour_of(map, place(0, 0));
                    double explained = 0;
                    for (const double a : {-curvature_error, curvature_error})
                        for (const double b : {-curvature_error, curvature_error})
                            explained =
                                std::max(explained, greatest_difference(colour_of(map, place(a, b)),
                                                                        expected));
                    EXPECT_EQ(pixel[3], 1);
                    worst = std::max(worst, greatest_difference(rgb(pixel), expected) - explained);
                });
            EXPECT_LT(worst, half_rounding + 1e-4) << name_of(measure); // between two of 257 texels
            EXPECT_TRUE(report.notes.empty());
        }
}

TEST_F(CurvatureEffects, ASphereHasOneColour) {
    Scene scene{.field = sampled(builtin_field("sphere"), 48)};
    scene.look.effects.curvature_colour = {.strength = 1, .range = {{-2, 2}}};
    const Image image = draw(scene, FrameImage::CurvatureColour);
    const Vec3d expected = colour_of(ColourMap::CoolWarm, 0.75); // 1 in [-2, 2]
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        if (image.rgba[i + 3] == 0) continue;
        // A radius of 15.7 voxels: 15/12/15.7^2 of the curvature, a quarter of that of the map,
        // whose slope is at most 4.
        EXPECT_LT(greatest_difference(rgb(&image.rgba[i]), expected), 0.006);
    }
}

TEST_F(CurvatureEffects, APlaneIsTheMiddleOfCoolWarm) {
    Scene scene{.field = plane};
    // Not near the field's border, where its samples continue and so bend.
    camera.projection = Projection::Orthographic;
    camera.height_world = 0.6;
    scene.look.effects.curvature_colour.strength = 1;
    const Image image = draw(scene, FrameImage::CurvatureColour);
    const Vec3d middle = colour_of(ColourMap::CoolWarm, 0.5);
    int count = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        if (image.rgba[i + 3] == 0) continue;
        ++count;
        // The layer's rounding, and once more for what samples' rounding bends.
        EXPECT_LT(greatest_difference(rgb(&image.rgba[i]), middle), half_rounding);
    }
    EXPECT_GT(count, 500);
    // Nor does what rounding bends count as concave.
    scene.look.effects.accessibility.strength = 1;
    const Image accessible = draw(scene, FrameImage::Accessibility);
    EXPECT_TRUE(std::ranges::all_of(accessible.rgba, [](float c) { return c == 0; }));
    EXPECT_TRUE(report.notes.empty());
}

TEST_F(CurvatureEffects, TheRangeIsOfTheFirstPictureAndStays) {
    Scene scene{.field = torus};
    scene.look.effects.curvature_colour = {.strength = 1, .measure = CurvatureMeasure::K2};
    renderer.load(scene);
    const auto note = [&] {
        return renderer
            .draw(camera, size, size, {FrameImage::CurvatureColour, FrameImage::Curvature})
            .notes.at(0);
    };
    const std::string first = note();
    const Image curvatures = renderer.read(FrameImage::Curvature);
    std::vector<double> sizes;
    for (std::size_t i = 0; i < curvatures.rgba.size(); i += 4)
        if (curvatures.rgba[i + 3] != 0) sizes.push_back(std::abs(double{curvatures.rgba[i + 1]}));
    std::ranges::sort(sizes);
    const double end = sizes[std::size_t(0.98 * double(sizes.size() - 1))];
    double low = 0;
    double high = 0;
    ASSERT_EQ(std::sscanf(first.c_str(),
                          "curvature colour: second principal curvature from %lf to %lf", &low,
                          &high),
              2)
        << first;
    EXPECT_NEAR(high, end, 5e-4 * end); // four digits are written
    EXPECT_EQ(low, -high);
    camera.eye_world = {0, 4, 0.5}; // sees the outside alone
    EXPECT_EQ(note(), first);
    scene.look.lights[0].direction = {1, 1, 1};
    renderer.set_look(scene.look);
    EXPECT_EQ(note(), first) << "as where a light moves in a sequence";
    scene.look.effects.curvature_colour.measure = CurvatureMeasure::K1;
    renderer.set_look(scene.look);
    EXPECT_EQ(note().find("first principal curvature"), std::string("curvature colour: ").size())
        << "another number";
    scene.look.effects.curvature_colour.measure = CurvatureMeasure::K2;
    renderer.set_look(scene.look);
    renderer.set_iso(0.01);
    EXPECT_EQ(note(), first);
    const LookNumbers numbers = renderer.look_numbers();
    renderer.load(scene);
    EXPECT_NE(note(), first);
    renderer.load(scene);
    renderer.set_look_numbers(numbers);
    EXPECT_EQ(note(), first);
}

TEST_F(CurvatureEffects, AMapShowsBothCurvaturesWhereTheyLie) {
    // A picture whose red is k1's place and whose green is k2's, upwards.
    Image picture{64, 64, {}};
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            for (const double c : {(x + 0.5) / 64, (63.5 - y) / 64, 0.0, 0.5})
                picture.rgba.push_back(static_cast<float>(c));
    Scene scene{.field = torus};
    scene.look.effects.curvature_map = {.strength = 1, .picture = picture, .range = 4};
    for_each_texel(scene, FrameImage::CurvatureMap, [&](const float* pixel, double k1, double k2) {
        EXPECT_NEAR(pixel[0], 0.5 + k1 / 8, curvature_error / 8 + half_rounding);
        EXPECT_NEAR(pixel[1], 0.5 + k2 / 8, curvature_error / 8 + half_rounding);
        EXPECT_EQ(pixel[3], 0.5); // the picture's coverage
    });
}

TEST_F(CurvatureEffects, TheBuiltInMapShowsATorusAsRidgeAndSaddle) {
    Scene scene{.field = torus};
    scene.look.effects.curvature_map = {.strength = 1, .range = 1 / minor};
    for_each_texel(scene, FrameImage::CurvatureMap, [&](const float* pixel, double k1, double k2) {
        const Vec3d expected = builtin_curvature_map(1, k2 / k1);
        // The map's slope is at most 2, its texels are 2/129 wide.
        EXPECT_LT(greatest_difference(rgb(pixel), expected),
                  2 * (curvature_error * minor + 1.0 / 129));
    });
}

TEST_F(CurvatureEffects, AccessibilityDarkensConcavePlacesAlone) {
    Scene scene{.field = torus};
    scene.look.effects.accessibility = {.strength = 1, .radius_world = 0.8};
    int dark = 0;
    for_each_texel(scene, FrameImage::Accessibility, [&](const float* pixel, double, double k2) {
        EXPECT_EQ(rgb(pixel), Vec3d::Zero());
        EXPECT_NEAR(pixel[3], std::clamp(-k2 * 0.8, 0.0, 1.0),
                    0.8 * curvature_error + half_rounding);
        if (pixel[3] > 0.5) ++dark;
    });
    EXPECT_GT(dark, 100);
    Scene convex{.field = sampled(builtin_field("sphere"), 48)};
    convex.look.effects.accessibility.strength = 1;
    const Image image = draw(convex, FrameImage::Accessibility);
    EXPECT_TRUE(std::ranges::all_of(image.rgba, [](float c) { return c == 0; }));
}

TEST_F(CurvatureEffects, AccessibilityIsBlackInTheTightestPlaces) {
    Scene scene{.field = torus};
    scene.look.effects.accessibility.strength = 1;
    const Image image = draw(scene, FrameImage::Accessibility);
    int concave = 0;
    int black = 0;
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
        concave += image.rgba[i] > 0.001F; // not flat
        black += image.rgba[i] == 1;
    }
    EXPECT_NEAR(double(black) / concave, 0.05, 0.01);
}

TEST_F(CurvatureEffects, ThatCannotBeAreRefused) {
    Look look;
    look.effects.curvature_colour.range = {{1, 1}};
    EXPECT_THROW(renderer.set_look(look), InputError);
    look = {};
    look.effects.curvature_map.range = 0;
    EXPECT_THROW(renderer.set_look(look), InputError);
    look = {};
    look.effects.accessibility.radius_world = -1;
    EXPECT_THROW(renderer.set_look(look), InputError);
    look = {};
    look.effects.refraction.index = 0;
    EXPECT_THROW(renderer.set_look(look), InputError);
    look = {};
    look.environment.kind = Environment::Kind::Picture;
    EXPECT_THROW(renderer.set_look(look), InputError);
}

} // namespace
} // namespace isocast::test
