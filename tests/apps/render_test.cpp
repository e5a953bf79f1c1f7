// `isocast render`, on Mesa's software driver: files, reports, and pictures of known surfaces.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "program.h"
#include "volume/analytic_fields.h"

#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfMatrixAttribute.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <map>

namespace isocast::test {
namespace {

using Json = nlohmann::json;

std::vector<std::string> render(const std::string& input, const std::string& output,
                                const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"render",    input,    "-o",     output,
                                       "--backend", "osmesa", "--size", "48x32"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

/// Channels of an EXR file, as float.
struct ExrFile {
    explicit ExrFile(const std::string& path) : file(path.c_str()) {
        const Imath::Box2i window = file.header().dataWindow();
        width = window.max.x + 1;
        height = window.max.y + 1;
        Imf::FrameBuffer frame;
        const auto row = static_cast<std::size_t>(width);
        for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c) {
            auto& values = channels[c.name()];
            values.resize(row * static_cast<std::size_t>(height));
            frame.insert(c.name(), Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()),
                                              sizeof(float), row * sizeof(float)));
        }
        file.setFrameBuffer(frame);
        file.readPixels(0, height - 1);
    }
    Vec3d vector(const std::string& layer, std::size_t i) const {
        return {channels.at(layer + ".X")[i], channels.at(layer + ".Y")[i],
                channels.at(layer + ".Z")[i]};
    }

    Imf::InputFile file;
    int width = 0;
    int height = 0;
    std::map<std::string, std::vector<float>> channels;
};

TEST(Render, PngHasTheSizeAskedFor) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.png";
    checked_output(isocast(render("field:torus@16", path)));
    const std::string png = contents_of(path);
    ASSERT_GT(png.size(), 24u);
    EXPECT_EQ(png.substr(1, 3), "PNG");
    // IHDR: width and height, big-endian, from byte 16.
    EXPECT_EQ(png.substr(16, 8), std::string("\0\0\0\x30\0\0\0\x20", 8));
    EXPECT_EQ(folder.entry_count(), 1);
}

TEST(Render, JsonHasTheDocumentedKeys) {
    const TemporaryFolder folder;
    const Outcome outcome =
        isocast(render("mesh:knot", folder / "a.png", {"--resolution", "24", "--json"}));
    EXPECT_EQ(outcome.err, "");
    const Json json = Json::parse(checked_output(outcome));
    for (const char* key :
         {"gl", "size", "passes", "programs", "texture_bytes", "bricks", "seconds", "warnings"})
        EXPECT_TRUE(json.contains(key)) << key;
    for (const char* key : {"backend", "vendor", "renderer", "version"})
        EXPECT_FALSE(json["gl"][key].get<std::string>().empty()) << key;
    EXPECT_EQ(json["gl"]["backend"], "osmesa");
    EXPECT_EQ(json["size"], Json({48, 32}));
    EXPECT_GT(json["texture_bytes"], 0);
    EXPECT_GT(json["bricks"]["active"], 0);
    EXPECT_EQ(json["bricks"]["active"], json["bricks"]["resident"]);
    EXPECT_GT(json["seconds"]["total"], 0.0);
    ASSERT_FALSE(json["passes"].empty());
    for (const Json& pass : json["passes"]) {
        for (const char* key : {"name", "ms", "bytes", "asked_by"})
            EXPECT_TRUE(pass.contains(key)) << key;
        EXPECT_GT(pass["bytes"], 0);
        EXPECT_FALSE(pass["asked_by"].get<std::string>().empty());
    }
    EXPECT_EQ(json["passes"].back()["asked_by"], "output");
    EXPECT_EQ(json["programs"], json["passes"].size());
}

TEST(Render, ExplainNamesEveryPass) {
    const TemporaryFolder folder;
    const std::string text = checked_output(
        isocast(render("field:torus@16", folder / "a.png", {"--explain", "--repeat", "3"})));
    for (const char* name : {"asked by", "bounds", "raycast", "gradient", "shading", "output"})
        EXPECT_NE(text.find(name), std::string::npos) << text;
}

TEST(Render, DrawsEveryKindOfInput) {
    const TemporaryFolder folder;
    checked_output(isocast({"sample", "mesh:torus", "-o", folder / "a.stl"}));
    checked_output(
        isocast({"convert", folder / "a.stl", "-o", folder / "a.vdb", "--resolution", "24"}));
    for (const std::string& input :
         {(folder / "a.stl").string(), (folder / "a.vdb").string(),
          (folder / "a.vdb").string() + ":surface", std::string("mesh:seashell"),
          std::string("field:marschner-lobb@16")}) {
        std::vector<std::string> more{"--json"};
        if (input.ends_with("stl") || input.starts_with("mesh:"))
            more.insert(more.end(), {"--resolution", "24"});
        const Json json =
            Json::parse(checked_output(isocast(render(input, folder / "a.png", more))));
        EXPECT_GT(json["bricks"]["active"], 0) << input;
    }
}

TEST(Render, ExrHoldsTheDocumentedChannelsAndAttributes) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.exr";
    checked_output(isocast(render("field:torus@16", path, {"--aov", "P,N", "--iso", "0.0625"})));
    const ExrFile exr(path);
    const Imf::Header& header = exr.file.header();
    EXPECT_EQ(exr.width, 48);
    EXPECT_EQ(exr.height, 32);
    EXPECT_EQ(exr.channels.size(), 11u);
    for (const char* name : {"R", "G", "B", "A"})
        EXPECT_EQ(header.channels()[name].type, Imf::HALF) << name;
    for (const char* name : {"Z", "P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z"})
        EXPECT_EQ(header.channels()[name].type, Imf::FLOAT) << name;
    EXPECT_EQ(header.compression(), Imf::ZIP_COMPRESSION);
    EXPECT_EQ(header.typedAttribute<Imf::FloatAttribute>("iso").value(), 0.0625f);
    EXPECT_GT(header.typedAttribute<Imf::FloatAttribute>("voxelSize").value(), 0);
    EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("filter").value(),
              "cubic B-spline, smoothing");
    EXPECT_FALSE(header.typedAttribute<Imf::StringAttribute>("glRenderer").value().empty());
    EXPECT_TRUE(header.findTypedAttribute<Imf::M44fAttribute>("worldToCamera"));
    EXPECT_TRUE(header.findTypedAttribute<Imf::M44fAttribute>("worldToNDC"));

    // Without --aov there are colour and depth only.
    checked_output(isocast(render("field:torus@16", path)));
    EXPECT_EQ(ExrFile(path).channels.size(), 5u);
}

class RenderedSphere : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Cameras, RenderedSphere,
                         testing::Values("direction=1,2,3;fov=40",
                                         "eye=3,1,-2;target=0.1,0,0;up=0,0,1",
                                         "direction=-1,0.2,0.3;height=2.5"));

TEST_P(RenderedSphere, PositionsDepthsAndNormalsAgreeWithItsEquation) {
    const TemporaryFolder folder;
    checked_output(isocast(
        render("field:sphere@48", folder / "a.exr", {"--aov", "P,N", "--camera", GetParam()})));
    const ExrFile exr(folder / "a.exr");
    const AnalyticField sphere = builtin_field("sphere");
    // Imath's matrices act on row vectors.
    const auto ndc = exr.file.header().typedAttribute<Imf::M44fAttribute>("worldToNDC").value();
    const auto to_camera =
        exr.file.header().typedAttribute<Imf::M44fAttribute>("worldToCamera").value();
    const double voxel = 2 * sphere.half_extent_world / 47;

    int hits = 0;
    for (int y = 0; y < exr.height; ++y)
        for (int x = 0; x < exr.width; ++x) {
            const auto i = static_cast<std::size_t>(y * exr.width + x);
            if (exr.channels.at("A")[i] == 0) {
                EXPECT_TRUE(std::isinf(exr.channels.at("Z")[i]));
                continue;
            }
            ++hits;
            const Vec3d p = exr.vector("P", i);
            const Jet jet = sphere.jet(p);
            // The smoothing B-spline adds h^2/6 of the Laplacian, which is 2/r for a distance: the
            // surface lies h^2/3 inside the unit sphere. 1e-4 voxels: terms of (h/r)^3 = 3e-4, of
            // which 4e-5 were measured.
            EXPECT_NEAR(jet.value / voxel, -voxel / 3, 1e-4);
            // 1e-6, an angle of 0.08 degrees: by symmetry the error is of order (h/r)^4 = 2e-5 rad
            // of angle times a small factor, and float32.
            EXPECT_GT(exr.vector("N", i).dot(jet.gradient.normalized()), 1 - 1e-6);
            Imath::V3f projected, in_camera;
            const Imath::V3f point(float(p.x()), float(p.y()), float(p.z()));
            ndc.multVecMatrix(point, projected);
            to_camera.multVecMatrix(point, in_camera);
            // 1e-4 of the picture's half: float32 positions through a float32 matrix, and rays that
            // are affine in the pixel in float32; a pixel's half is 2e-2.
            EXPECT_NEAR(projected.x, 2 * (x + 0.5) / exr.width - 1, 1e-4);
            EXPECT_NEAR(projected.y, 1 - 2 * (y + 0.5) / exr.height, 1e-4);
            EXPECT_NEAR(exr.channels.at("Z")[i], -in_camera.z, 1e-5); // float32 below 10
        }
    EXPECT_GT(hits, exr.width * exr.height / 10);
}

TEST(Render, FieldThatNeverCrossesTheIsoValueIsBackgroundAndAWarning) {
    const TemporaryFolder folder;
    const Outcome outcome =
        isocast(render("field:torus@16", folder / "a.exr", {"--iso", "100", "--json"}));
    const Json json = Json::parse(checked_output(outcome));
    ASSERT_EQ(json["warnings"].size(), 1u);
    EXPECT_NE(outcome.err.find("field:torus@16"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("never crosses the iso value 100"), std::string::npos);
    EXPECT_EQ(json["bricks"]["active"], 0);
    const ExrFile exr(folder / "a.exr");
    for (const float alpha : exr.channels.at("A")) EXPECT_EQ(alpha, 0);
}

TEST(Render, IsTheSameEveryTime) {
    const TemporaryFolder folder;
    for (const char* name : {"a.png", "b.png"})
        checked_output(isocast(render("field:gyroid@16", folder / name, {"--repeat", "2"})));
    EXPECT_EQ(contents_of(folder / "a.png"), contents_of(folder / "b.png"));
}

} // namespace
} // namespace isocast::test
