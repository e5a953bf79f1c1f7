// Stereo pairs: parallel frusta, and the files that hold both views.
// SPDX-License-Identifier: MPL-2.0
#include "apps/stereo.h"

#include "../volume/temporary_folder.h"
#include "apps/inputs.h"
#include "apps/picture.h"
#include "exr_file.h"
#include "program.h"
#include "quadrics/quadric.h"
#include "volume/errors.h"

#include <ImfMatrixAttribute.h>
#include <ImfMultiView.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>

namespace isocast::test {
namespace {

struct Stereo : testing::Test {
    TemporaryFolder folder;
    SceneFile scene{.output = {.width = 150, .height = 100}};
    Camera camera{.eye_world = {1, 2, 6}, .target_world = {0.5, 0, 1}, .up = {0.1, 2, 0}};
    double distance_world = (camera.target_world - camera.eye_world).norm();
    double pixel_world = 2 * camera.half_height_at(distance_world) / 100; // at the target

    std::vector<PictureView> views(double separation_world) {
        scene.camera.is_stereo = true;
        scene.camera.eye_separation_world = separation_world;
        return views_of(scene, camera);
    }
    Ray ray_of(const PictureView& view, double x, double y) const {
        return camera_ray(view.camera, view.picture_width, 100, view.first_pixel + x, y);
    }
    /// Where the window shows a point, from its left [pixels].
    double x_of(const PictureView& view, const Vec3d& p_world) const {
        const Vec3d p = view.camera.view_from_world_rotation() * (p_world - view.camera.eye_world);
        return view.picture_width / 2.0 - view.first_pixel +
               p.x() / -p.z() * 50 / view.camera.half_height_at(1);
    }
};

TEST_F(Stereo, PixelsOfBothEyesShowTheSamePointOfTheTargetsPlane) {
    const PictureView one{.camera = camera, .picture_width = 150};
    const Vec3d axis = (camera.target_world - camera.eye_world).normalized();
    for (const double separation : {0.02, 0.3, 4.0}) {
        const auto pair = views(separation);
        ASSERT_EQ(pair.size(), 2);
        EXPECT_NEAR((pair[1].camera.eye_world - pair[0].camera.eye_world)
                        .dot(camera.view_from_world_rotation().row(0)),
                    separation, 1e-14);
        for (const Eigen::Vector2d& pixel :
             {Eigen::Vector2d(0, 0), {150, 100}, {75, 50}, {13.5, 77.5}}) {
            const auto in_plane = [&](const PictureView& view) -> Vec3d {
                const Ray ray = ray_of(view, pixel.x(), pixel.y());
                return ray.origin_world +
                       ray.direction_world * (axis.dot(camera.target_world - ray.origin_world) /
                                              axis.dot(ray.direction_world));
            };
            // 1/256: windows begin at multiples of 1/128 of a pixel.
            for (const PictureView& view : pair)
                EXPECT_LT((in_plane(view) - in_plane(one)).norm(), pixel_world * 1.001 / 256);
        }
    }
}

TEST_F(Stereo, DisparityIsNoneAtTheTargetAndTheSeparationsAtInfinity) {
    const double separation = 0.25;
    const auto pair = views(separation);
    const Vec3d ahead = camera.target_world - camera.eye_world;
    const auto disparity = [&](const Vec3d& p) { return x_of(pair[1], p) - x_of(pair[0], p); };
    EXPECT_LT(std::abs(disparity(camera.target_world)), 1.001 / 128);
    // The separation, as long as it is at the target; nearer things are crossed.
    const double at_infinity = separation / pixel_world;
    EXPECT_NEAR(disparity(camera.eye_world + 1e9 * ahead), at_infinity, 1.0 / 128 + 1e-6);
    EXPECT_NEAR(disparity(camera.eye_world + 0.5 * ahead), -at_infinity, 1.0 / 128 + 1e-6);
    EXPECT_GT(at_infinity, 5);
    // Unless said, the separation is 1/30 of the target's distance.
    scene.camera.eye_separation_world.reset();
    const auto by_itself = views_of(scene, camera);
    EXPECT_NEAR((by_itself[1].camera.eye_world - by_itself[0].camera.eye_world).norm(),
                distance_world / 30, 1e-14);
}

TEST_F(Stereo, EachEyesPictureIsWhatItsRaysMeet) {
    Primitives some;
    for (int i = 0; i < 12; ++i)
        some.spheres.push_back(
            {.centre_world = camera.target_world + Vec3d(std::cos(i), std::sin(2 * i), std::sin(i)),
             .radius_world = 0.4});
    const auto context = gl::make_context({.backend = gl::Backend::Osmesa});
    Renderer renderer(*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders");
    renderer.load({.primitives = std::make_shared<Primitives>(some)});
    const auto pair = views(0.3);
    for (const int tile : {0, 37}) {
        std::array<int, 2> shown{};
        int row = 0;
        draw_picture(
            source_of(renderer), pair,
            {.width = 150, .height = 100, .others = {FrameImage::Hit}, .tile_pixels = tile},
            [&](const std::vector<FrameImages>& rows) {
                ASSERT_EQ(rows.size(), 2);
                const int height = rows[0].at(FrameImage::Hit).height;
                for (int y = 0; y < height; ++y)
                    for (int x = 0; x < 150; ++x)
                        for (std::size_t v = 0; v < 2; ++v) {
                            const Ray ray = ray_of(pair[v], x + 0.5, row + y + 0.5);
                            double t = std::numeric_limits<double>::infinity();
                            for (const Sphere& sphere : some.spheres)
                                if (const auto hit =
                                        intersect(sphere, ray.origin_world, ray.direction_world))
                                    t = std::min(t, hit->t);
                            const float* hit = rows[v].at(FrameImage::Hit).pixel(x, y);
                            ASSERT_EQ(hit[3] != 0, std::isfinite(t)) << x << ", " << row + y;
                            if (hit[3] == 0) continue;
                            ++shown[v];
                            // Grazing rays are off by the root of a rounding of a few units.
                            EXPECT_LT(
                                (Vec3d(hit[0], hit[1], hit[2]) - t * ray.direction_world).norm(),
                                2e-3);
                        }
                row += height;
            });
        EXPECT_EQ(row, 100);
        for (const int count : shown) EXPECT_GT(count, 1000);
    }
}

TEST_F(Stereo, OfNoWidthIsThePictureTwiceAndTilesChangeNoBit) {
    const std::string mesh = "mesh:knot";
    const auto render = [&](const char* name, std::vector<std::string> more) {
        std::vector<std::string> arguments{"render", mesh, "-o", folder / name};
        for (const char* key : {"object.as=triangles", "light.shadow=soft",
                                "effects.outlines.strength=1", "output.samples=2"})
            arguments.insert(arguments.end(), {"--set", key});
        arguments.insert(arguments.end(), {"--size", "90x60"});
        for (const std::string& key : more) arguments.insert(arguments.end(), {"--set", key});
        checked_output(isocast(arguments));
        return read_picture(folder / name);
    };
    const Image one = render("one.png", {});
    const Image same = render("same.png", {"camera.stereo=1e-9"});
    const Image pair = render("pair.png", {"camera.stereo=auto"});
    ASSERT_EQ(same.width, 180);
    ASSERT_EQ(same.height, 60);
    int differing = 0;
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 90; ++x)
            for (int c = 0; c < 3; ++c) {
                ASSERT_EQ(same.pixel(x, y)[c], one.pixel(x, y)[c]);
                ASSERT_EQ(same.pixel(90 + x, y)[c], one.pixel(x, y)[c]);
                differing += pair.pixel(x, y)[c] != pair.pixel(90 + x, y)[c];
            }
    EXPECT_GT(differing, 1000);
    EXPECT_EQ(render("tiles.png", {"camera.stereo=auto", "output.tile=23"}).rgba, pair.rgba);
}

TEST_F(Stereo, ExrHasBothViewsAndTheMatricesOfEach) {
    const std::string path = folder / "pair.exr";
    checked_output(isocast({"render", "field:sphere@32", "-o", path, "--aov", "P,N", "--size",
                            "80x60", "--set", "camera.stereo=0.4"}));
    const ExrFile exr(path);
    const Imf::Header& header = exr.file.header();
    ASSERT_TRUE(Imf::hasMultiView(header));
    const Imf::StringVector& names = Imf::multiView(header);
    EXPECT_EQ(names, (Imf::StringVector{"left", "right"}));
    EXPECT_EQ(Imf::viewFromChannelName("R", names), "left");
    EXPECT_EQ(Imf::viewFromChannelName("right.R", names), "right");
    for (const char* channel : {"R", "G", "B", "A", "Z", "N.left.X"}) {
        EXPECT_TRUE(exr.channels.contains(channel)) << channel;
        EXPECT_TRUE(exr.channels.contains(
            Imf::channelInOtherView(channel, header.channels(), names, "right")))
            << channel;
    }
    EXPECT_EQ(exr.channels.size(), 2 * (5 + 6));
    double greatest_shift = 0;
    for (const bool is_left : {true, false}) {
        const auto& matrix =
            header.typedAttribute<Imf::M44fAttribute>(is_left ? "worldToNDC" : "worldToNDC.right")
                .value();
        const auto& z = exr.channels.at(is_left ? "Z" : "right.Z");
        int hits = 0;
        for (std::size_t i = 0; i < z.size(); ++i) {
            if (!std::isfinite(z[i])) continue;
            ++hits;
            const Vec3d p = exr.vector(is_left ? "P.left" : "P.right", i);
            Imath::V3f ndc;
            matrix.multVecMatrix(Imath::V3f(float(p.x()), float(p.y()), float(p.z())), ndc);
            // Floats of positions of a few units: 1e-4 of a pixel.
            EXPECT_NEAR((ndc.x + 1) / 2 * 80, double(i % 80) + 0.5, 1e-3);
            EXPECT_NEAR((1 - ndc.y) / 2 * 60, double(i / 80) + 0.5, 1e-3);
        }
        EXPECT_GT(hits, 500);
    }
    for (std::size_t i = 0; i < exr.channels.at("Z").size(); ++i)
        if (const double shift = std::abs(exr.channels.at("Z")[i] - exr.channels.at("right.Z")[i]);
            std::isfinite(shift))
            greatest_shift = std::max(greatest_shift, shift);
    EXPECT_GT(greatest_shift, 0.01);
}

TEST_F(Stereo, SequencesArePairsOfEachFrame) {
    checked_output(isocast({"render", "mesh:torus", "-o", folder / "pair_%d.png", "--frames", "2",
                            "--size", "40x30", "--set", "camera.turntable=90", "--set",
                            "camera.stereo=auto", "--set", "object.as=triangles"}));
    for (const char* name : {"pair_0.png", "pair_1.png"})
        EXPECT_EQ(read_picture(folder / name).width, 80);
}

TEST_F(Stereo, ThatCannotBeIsRefused) {
    const auto code = [&](const char* key, std::vector<std::string> more = {}) {
        more.insert(more.begin(), {"render", "mesh:torus", "-o", folder / "x.png", "--set", key});
        const Outcome outcome = isocast(more);
        EXPECT_NE(outcome.err.find("camera.stereo"), std::string::npos) << outcome.err;
        return outcome.code;
    };
    for (const char* key : {"camera.stereo=0", "camera.stereo=-1", "camera.stereo=wide",
                            "camera.stereo=[1, 2]", "camera.stereo=nan"})
        EXPECT_EQ(code(key), 2) << key;
    EXPECT_EQ(code("camera.stereo=auto", {"--set", "camera.height=2"}), 3);
}

} // namespace
} // namespace isocast::test
