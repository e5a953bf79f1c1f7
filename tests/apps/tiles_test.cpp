// Pictures of any size and of many samples a pixel.
// SPDX-License-Identifier: MPL-2.0
#include "apps/picture.h"

#include "../volume/temporary_folder.h"
#include "program.h"
#include "raycaster/image_files.h"
#include "test_context.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <numbers>
#include <set>

namespace isocast::test {
namespace {

TEST(PartsOf, CoverThePictureOnceRowByRow) {
    for (const auto& [width, height, tile, limit] :
         {std::array{100, 70, 0, 16384}, std::array{100, 70, 16, 16384},
          std::array{5000, 5000, 0, 16384}, std::array{20000, 900, 0, 16384},
          std::array{300, 10, 0, 128}, std::array{7, 5, 1, 128}}) {
        const std::vector<PicturePart> parts = parts_of(width, height, tile, limit);
        std::int64_t area = 0;
        int x = 0;
        int y = 0;
        for (const PicturePart& part : parts) {
            EXPECT_EQ(part.x, x);
            EXPECT_EQ(part.y, y);
            EXPECT_LE(std::max(part.width, part.height), limit);
            EXPECT_LE(std::int64_t{part.width} * part.height, 1 << 24);
            area += std::int64_t{part.width} * part.height;
            x += part.width;
            if (x == width) {
                x = 0;
                y += part.height;
            }
        }
        EXPECT_EQ(area, std::int64_t{width} * height);
        EXPECT_EQ(y, height);
        EXPECT_EQ(parts.size() == 1, tile == 0 && width == 100);
    }
}

TEST(SampleShifts, LieInAllRowsAndColumnsOfAPixel) {
    for (const int n : {1, 2, 4, 8, 16, 32, 64}) {
        std::set<int> rows;
        std::set<int> columns;
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        for (const Eigen::Vector2d& shift : sample_shifts(n, PixelFilter::Box)) {
            columns.insert(static_cast<int>(std::floor((shift.x() + 0.5) * n)));
            rows.insert(static_cast<int>(std::floor((shift.y() + 0.5) * n)));
            EXPECT_EQ(shift * 128, Eigen::Vector2d((shift * 128).array().round()))
                << "floats must hold it beside 2^17 pixels";
            sum += shift;
        }
        EXPECT_EQ(rows.size(), static_cast<std::size_t>(n));
        EXPECT_EQ(columns.size(), static_cast<std::size_t>(n));
        // The middles of n strata have their mean in the middle.
        EXPECT_EQ(sum, Eigen::Vector2d::Zero());
    }
}

TEST(SampleShifts, HaveTheVarianceOfTheFilter) {
    const auto variance = [](PixelFilter filter) {
        double sum = 0;
        for (const Eigen::Vector2d& shift : sample_shifts(64, filter)) sum += shift.x() * shift.x();
        return sum / 64;
    };
    // A box of width 1: 1/12; a tent of two: 1/6. 64 middles of strata are 1/64^2 off, and places
    // rounded to 1/128 as much again.
    EXPECT_NEAR(variance(PixelFilter::Box), 1.0 / 12, 1e-3);
    EXPECT_NEAR(variance(PixelFilter::Tent), 1.0 / 6, 1e-3);
}

TEST(Reach, IsThatOfTheWidestEffect) {
    Look look;
    EXPECT_EQ(reach_pixels(look), 0);
    look.effects.outlines.strength = 0.1;
    EXPECT_EQ(reach_pixels(look), 1);
    look.effects.flow = {.strength = 1, .length_pixels = 19.5};
    EXPECT_EQ(reach_pixels(look), 11) << "ten steps, and a pixel beside the last";
}

struct Pictures : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders"};
    Camera camera{.eye_world = {1.6, 1.2, 3.5}, .target_world = {0.1, 0, 0}};
    FrameReport report;

    /// All rows of each image, one after the other.
    std::map<FrameImage, Image> draw(const PictureRequest& request) {
        std::map<FrameImage, Image> whole;
        const std::vector<PictureView> views{{.camera = camera, .picture_width = request.width}};
        report = draw_picture(
            source_of(renderer), views, request, [&](const std::vector<FrameImages>& rows) {
                for (const auto& [image, part] : rows.front()) {
                    Image& out = whole[image];
                    EXPECT_EQ(part.width, request.width);
                    out.width = part.width;
                    out.height += part.height;
                    out.rgba.insert(out.rgba.end(), part.rgba.begin(), part.rgba.end());
                }
            });
        return whole;
    }
    const PassReport& pass(std::string_view name) const {
        for (const PassReport& p : report.passes)
            if (p.name == name) return p;
        throw std::logic_error("no such pass");
    }
};

TEST_F(Pictures, InTilesEqualTheWholeBitByBit) {
    renderer.load({.field = sampled(builtin_field("gyroid"), 32)});
    for (const int samples : {1, 4}) {
        PictureRequest request{.width = 61,
                               .height = 45,
                               .others = {FrameImage::Hit, FrameImage::Curvature},
                               .samples = samples,
                               .pixel_filter = PixelFilter::Tent};
        const auto whole = draw(request);
        EXPECT_GT(std::ranges::count(whole.at(FrameImage::Hit).rgba, 1.0F), 500);
        request.tile_pixels = 23;
        const auto tiled = draw(request);
        ASSERT_EQ(tiled.size(), 3u);
        for (const auto& [image, expected] : whole) {
            EXPECT_EQ(tiled.at(image).height, 45);
            EXPECT_EQ(tiled.at(image).rgba, expected.rgba) << name_of(image);
        }
        // Textures are as large as a tile.
        EXPECT_EQ(pass("raycast").texture_bytes, 23 * 23 * 16);
    }
}

struct LookOfTiles {
    const char* name;
    void (*set)(Look&);
};
const std::vector<LookOfTiles> looks_of_tiles{
    {"Plain", [](Look&) {}},
    {"Gooch", [](Look& l) { l.model = ShadingModel::Gooch; }},
    {"EnvironmentAsBackground", [](Look& l) { l.shows_environment = true; }},
    {"Checker",
     [](Look& l) {
         l.effects.solid_texture = {.strength = 1, .kind = SolidTexture::Kind::Checker};
     }},
    {"Marble", [](Look& l) { l.effects.solid_texture.strength = 1; }},
    {"Wood",
     [](Look& l) { l.effects.solid_texture = {.strength = 1, .kind = SolidTexture::Kind::Wood}; }},
    {"VolumeTexture",
     [](Look& l) {
         l.effects.solid_texture = {.strength = 1,
                                    .kind = SolidTexture::Kind::Volume,
                                    .volume = sampled(builtin_field("torus"), 8)};
     }},
    {"CurvatureColour", [](Look& l) { l.effects.curvature_colour.strength = 1; }},
    {"Curvedness",
     [](Look& l) {
         l.effects.curvature_colour = {.strength = 1, .measure = CurvatureMeasure::Curvedness};
     }},
    {"CurvatureMap", [](Look& l) { l.effects.curvature_map.strength = 1; }},
    {"Uncertainty", [](Look& l) { l.effects.uncertainty.strength = 1; }},
    {"Flow", [](Look& l) { l.effects.flow.strength = 1; }},
    {"FlowThatTravels",
     [](Look& l) { l.effects.flow = {.strength = 1, .direction = 2, .phase = 0.3}; }},
    {"Accessibility", [](Look& l) { l.effects.accessibility.strength = 1; }},
    {"Occlusion", [](Look& l) { l.effects.occlusion = {.strength = 1, .rays = 4}; }},
    {"HardShadow", [](Look& l) { l.lights[0].shadow = Shadow::Hard; }},
    {"SoftShadow", [](Look& l) { l.lights[0].shadow = Shadow::Soft; }},
    {"Refraction", [](Look& l) { l.effects.refraction.strength = 1; }},
    {"Reflection",
     [](Look& l) {
         l.effects.reflection = {.strength = 1, .has_fresnel = true};
         l.environment.kind = isocast::Environment::Kind::Stripes;
     }},
    {"Ridges", [](Look& l) { l.effects.ridges.strength = 1; }},
    {"Contours", [](Look& l) { l.effects.contours.strength = 1; }},
    {"Outlines", [](Look& l) { l.effects.outlines.strength = 1; }},
    {"Slice", [](Look& l) { l.effects.slice.strength = 1; }},
    {"AllLines",
     [](Look& l) {
         l.effects.ridges.strength = l.effects.contours.strength = l.effects.outlines.strength = 1;
         l.effects.flow.strength = 1;
     }},
};

struct PicturesOf : Pictures, testing::WithParamInterface<LookOfTiles> {};

/// What takes numbers from the picture takes them from the same one, and what reads neighbours
/// finds them.
TEST_P(PicturesOf, EachEffectInTilesEqualTheWholeBitByBit) {
    Scene scene{.field = sampled(builtin_field("gyroid"), 32)};
    GetParam().set(scene.look);
    // One that is its own overview, of many samples; and one that is larger than its overview.
    for (const PictureRequest& request :
         {PictureRequest{.width = 61, .height = 45, .samples = 2, .tile_pixels = 23},
          PictureRequest{.width = 271, .height = 61, .tile_pixels = 47}}) {
        PictureRequest at_once = request;
        at_once.tile_pixels = 0;
        renderer.load(scene);
        const Image whole = draw(at_once).at(FrameImage::Beauty);
        const std::vector<std::string> notes = report.notes;
        renderer.load(scene);
        EXPECT_EQ(draw(request).at(FrameImage::Beauty).rgba, whole.rgba);
        for (const std::string& note : notes)
            EXPECT_EQ(std::ranges::count(report.notes, note), 1) << note;
    }
}

INSTANTIATE_TEST_SUITE_P(Looks, PicturesOf, testing::ValuesIn(looks_of_tiles),
                         [](const auto& test) { return test.param.name; });

TEST_F(Pictures, OfComposedObjectsInTilesEqualTheWholeBitByBit) {
    Scene scene{
        .objects = {{.field = sampled(builtin_field("gyroid"), 24)},
                    {.field = sampled(builtin_field("sphere"), 32)}},
        .tree = {{CsgOperation::Object, 1}, {CsgOperation::Object, 0}, {CsgOperation::Difference}}};
    scene.look.effects.occlusion = {.strength = 1, .rays = 4};
    scene.look.effects.curvature_colour.strength = 1;
    PictureRequest request{.width = 271, .height = 61};
    renderer.load(scene);
    const Image whole = draw(request).at(FrameImage::Beauty);
    renderer.load(scene);
    request.tile_pixels = 47;
    EXPECT_EQ(draw(request).at(FrameImage::Beauty).rgba, whole.rgba);
}

TEST_F(Pictures, LookForNumbersOnceAndOnlyForThoseThatAreNotGiven) {
    Scene scene{.field = sampled(builtin_field("gyroid"), 32)};
    scene.look.effects.ridges = {.strength = 1, .threshold = 2};
    scene.look.effects.curvature_colour = {.strength = 1,
                                           .range = std::array<double, 2>{-1.0, 1.0}};
    const PictureRequest request{.width = 300, .height = 60, .tile_pixels = 100};
    for (int turn = 0; turn < 2; ++turn) {
        renderer.load(scene);
        draw(request);
        EXPECT_TRUE(report.notes.empty()) << "no picture was drawn for them";
        EXPECT_EQ(report.scratch_bytes, 0);
        EXPECT_TRUE(renderer.look_numbers().empty());
        scene.look = {};
    }
    // Hits, gradients and curvatures of 256 x 51 pixels.
    scene.look.effects.curvature_colour.strength = 1;
    renderer.load(scene);
    draw(request);
    EXPECT_EQ(std::ranges::count(report.notes, "numbers that were not given: from 256 x 51 pixels"),
              1);
    EXPECT_EQ(report.scratch_bytes, 256 * 51 * 3 * 16);
    draw(request);
    EXPECT_EQ(report.scratch_bytes, 0) << "they are known";
    // A ball has no hollows, whichever part is looked at; it is looked for once.
    scene = {.field = sampled(builtin_field("sphere"), 32)};
    scene.look.effects.accessibility.strength = 1;
    renderer.load(scene);
    draw(request);
    EXPECT_EQ(report.notes.size(), 1u);
    EXPECT_FALSE(renderer.look_numbers().at("accessibility").value);
    draw(request);
    EXPECT_EQ(report.scratch_bytes, 0) << "it is known that there are none";
    camera.eye_world.z() = -3;
    draw(request);
    EXPECT_GT(report.scratch_bytes, 0) << "from elsewhere there may be some";
}

TEST_F(Pictures, OfManySamplesHaveOtherImagesFromTheMiddlesOfPixels) {
    renderer.load({.field = sampled(builtin_field("torus"), 32)});
    PictureRequest request{.width = 48, .height = 32, .others = {FrameImage::Hit}};
    const auto plain = draw(request);
    request.samples = 8;
    const auto smooth = draw(request);
    EXPECT_EQ(smooth.at(FrameImage::Hit).rgba, plain.at(FrameImage::Hit).rgba);
    EXPECT_NE(smooth.at(FrameImage::Beauty).rgba, plain.at(FrameImage::Beauty).rgba);
}

TEST_F(Pictures, WithoutBeautyShadeNothing) {
    renderer.load({.field = sampled(builtin_field("torus"), 32)});
    const auto images =
        draw({.width = 48, .height = 32, .has_beauty = false, .others = {FrameImage::Hit}});
    EXPECT_EQ(images.size(), 1u);
    EXPECT_FALSE(pass("shading").ran);
    EXPECT_FALSE(pass("gradient").ran);
    EXPECT_EQ(report.programs_compiled, 1);
    EXPECT_EQ(report.image_bytes, 48 * 32 * 16);
}

/// A sphere of radius 1 from afar, without light.
struct Disc : Pictures {
    static constexpr int size = 64;
    static constexpr double pixel_world = 3.0 / size;

    Disc() {
        Scene scene{.field = sampled(builtin_field("sphere"), 80)};
        scene.look.model = ShadingModel::Flat;
        scene.look.background = Vec3d::Zero();
        renderer.load(scene);
        camera = {.eye_world = {0, 0, 5},
                  .target_world = Vec3d::Zero(),
                  .projection = Projection::Orthographic,
                  .height_world = size * pixel_world};
    }
    /// How far the area of all coverage is from the disc's, in pixels: the root of the mean square
    /// over pictures whose pixels lie differently.
    double area_error(int samples, PixelFilter filter) {
        constexpr int places = 12;
        double sum = 0;
        for (int i = 0; i < places; ++i) {
            // Golden-section steps visit pixels evenly.
            const Eigen::Vector2d off(std::fmod(0.618034 * i, 1), std::fmod(0.754878 * i, 1));
            camera.eye_world = Vec3d(pixel_world * off.x(), pixel_world * off.y(), 5);
            camera.target_world = Vec3d(pixel_world * off.x(), pixel_world * off.y(), 0);
            const Image image =
                draw({.width = size, .height = size, .samples = samples, .pixel_filter = filter})
                    .at(FrameImage::Beauty);
            double area = 0;
            for (std::size_t p = 3; p < image.rgba.size(); p += 4) area += double{image.rgba[p]};
            // One that grazes the sphere within float's digits may go either way.
            EXPECT_NEAR(samples * area, samples_inside(samples, filter, off), 1);
            const double error = area - std::numbers::pi / (pixel_world * pixel_world);
            sum += error * error;
        }
        return std::sqrt(sum / places);
    }
    /// Of all pixels' samples, those in the disc; the camera is `off` pixels off the middle.
    static int samples_inside(int samples, PixelFilter filter, const Eigen::Vector2d& off) {
        int count = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                for (const Eigen::Vector2d& shift : sample_shifts(samples, filter))
                    count +=
                        std::hypot(x + 0.5 + shift.x() - size / 2 + off.x(),
                                   size / 2 - (y + 0.5 + shift.y()) + off.y()) < 1 / pixel_world;
        return count;
    }
};

TEST_F(Disc, AreaConvergesToTheAnalyticOne) {
    const double one = area_error(1, PixelFilter::Box);
    const double few = area_error(4, PixelFilter::Box);
    const double many = area_error(64, PixelFilter::Box);
    fmt::print("error of 1430 pixels: {:.3f} with 1 sample, {:.3f} with 4, {:.3f} with 64\n", one,
               few, many);
    // A circle of radius r on a lattice holds about r^(1/2) points too many or too few [Gauss's
    // circle problem]: 4.6 for 21 pixels. With n samples points have 1/n of the area, r grows by
    // n^(1/2), and the error falls like n^(-3/4): to 0.35 and 0.04. Hammersley's points are less
    // even than a lattice; that they go on falling is what is asked for.
    EXPECT_LT(one, 4.6);
    EXPECT_LT(few, 0.5 * one);
    EXPECT_LT(many, 0.15 * one);
    // A tent's weights sum to one as well.
    EXPECT_LT(area_error(64, PixelFilter::Tent), 0.2 * one);
}

TEST_F(Disc, CoverageIsOneInsideZeroOutsideAndASharePerSampleOnTheEdge) {
    const Image image = draw({.width = size, .height = size, .samples = 16}).at(FrameImage::Beauty);
    std::set<float> shares;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const float coverage = image.pixel(x, y)[3];
            const double r = pixel_world * std::hypot(x + 0.5 - size / 2.0, y + 0.5 - size / 2.0);
            // Half a pixel's diagonal.
            EXPECT_TRUE(r >= 1 - 0.71 * pixel_world || coverage == 1);
            EXPECT_TRUE(r <= 1 + 0.71 * pixel_world || coverage == 0);
            EXPECT_EQ(16 * coverage, std::round(16 * coverage));
            shares.insert(coverage);
            // Colours are multiplied by coverage: halves of 0.72, summed in float.
            EXPECT_NEAR(image.pixel(x, y)[0], coverage * 0.72, 0.72 / 2048);
        }
    EXPECT_GT(shares.size(), 10u);
}

TEST(TransparentPng, HasCoverageAsAlphaAndColoursThatAreNotDarkenedByIt) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.png";
    checked_output(isocast({"render", "field:sphere@32", "-o", path, "--size", "48x48", "--backend",
                            "osmesa", "--samples", "16", "--transparent", "--set",
                            "shading.model=flat", "--set", "shading.colour=[0.5, 0.25, 1]"}));
    const Image image = read_picture(path);
    int edges = 0;
    int inside = 0;
    int outside = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        const float alpha = image.rgba[i + 3];
        inside += alpha == 1;
        outside += alpha == 0;
        if (alpha == 0) continue;
        edges += alpha < 1;
        // 0.005: half a byte of sRGB near linear 0.5.
        EXPECT_NEAR(image.rgba[i], 0.5, 0.005);
        EXPECT_NEAR(image.rgba[i + 1], 0.25, 0.005);
        EXPECT_NEAR(image.rgba[i + 2], 1, 0.005);
    }
    EXPECT_GT(inside, 500);
    EXPECT_GT(outside, 100);
    EXPECT_GT(edges, 50);
}

TEST(LargePicture, ThatNoTextureHoldsIsDrawnInTilesWithLittleMemory) {
    const TemporaryFolder folder;
    // 20000 pixels: more than the 16384 that any known driver draws at once. From far to the side,
    // most of them are empty.
    const nlohmann::json json = nlohmann::json::parse(
        checked_output(isocast({"render", "field:sphere@16", "-o", folder / "a.png", "--size",
                                "20000x40", "--backend", "osmesa", "--json"})));
    const std::string png = contents_of(folder / "a.png");
    EXPECT_EQ(png.substr(16, 8), std::string("\0\0\x4e\x20\0\0\0\x28", 8));
    // Tiles of 4096 x 40: 16 bytes of hits, 16 of gradients, 8 of beauty.
    EXPECT_LE(json["texture_bytes"], 4096 * 40 * 40 + (1 << 20));
}

TEST(Tiles, ChangeNoBitOfAFile) {
    const TemporaryFolder folder;
    for (const std::string name : {"a.png", "a.exr"}) {
        const auto draw = [&](std::vector<std::string> more) {
            more.insert(more.begin(), {"render", "field:torus@24", "-o", folder / name, "--size",
                                       "61x47", "--backend", "osmesa", "--samples", "2"});
            if (name == "a.exr") more.insert(more.end(), {"--aov", "P,N,curvature,id"});
            checked_output(isocast(more));
            return contents_of(folder / name);
        };
        EXPECT_EQ(draw({"--tile", "16"}), draw({})) << name;
    }
}

} // namespace
} // namespace isocast::test
