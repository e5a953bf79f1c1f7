// `isocast render`, on Mesa's software driver: files, reports, and pictures of known surfaces.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "exr_file.h"
#include "program.h"
#include "volume/analytic_fields.h"

#include <ImfFloatAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>

namespace isocast::test {
namespace {

using Json = nlohmann::json;

std::vector<std::string> render(const std::string& input, const std::string& output,
                                const std::vector<std::string>& more = {}) {
    return joined({"render", input, "-o", output, "--backend", "osmesa", "--size", "48x32"}, more);
}

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
    std::size_t with_a_program = 0;
    for (const Json& pass : json["passes"]) {
        for (const char* key : {"name", "ms", "bytes", "asked_by", "drawn_by"})
            EXPECT_TRUE(pass.contains(key)) << key;
        EXPECT_GT(pass["bytes"], 0);
        EXPECT_FALSE(pass["asked_by"].get<std::string>().empty());
        EXPECT_EQ(pass["drawn_by"], pass["name"] == "gradient" ? "raycast" : "");
        with_a_program += pass["drawn_by"] == "";
    }
    EXPECT_EQ(json["passes"].back()["asked_by"], "output");
    EXPECT_EQ(json["programs"], with_a_program);
}

TEST(Render, ExplainNamesEveryPass) {
    const TemporaryFolder folder;
    const std::string text = checked_output(
        isocast(render("field:torus@16", folder / "a.png", {"--explain", "--repeat", "3"})));
    for (const char* name : {"asked by", "raycast", "gradient", "shading", "output"})
        EXPECT_NE(text.find(name), std::string::npos) << text;
}

TEST(Render, ReportsWhatWasAskedForAndWhatDidNotRun) {
    const TemporaryFolder folder;
    const std::vector<std::string> alone{"--aov", "P,curvature", "--no-beauty"};
    std::vector<std::string> more = alone;
    more.emplace_back("--json");
    const Json json =
        Json::parse(checked_output(isocast(render("field:torus@16", folder / "a.exr", more))));
    // No beauty is shaded, and no gradient, program or texture is there for it.
    std::vector<std::string> ran;
    for (const Json& pass : json["passes"]) ran.push_back(pass["name"]);
    EXPECT_EQ(ran, (std::vector<std::string>{"raycast", "curvature"}));
    EXPECT_EQ(json["programs"], 2);
    for (const char* name : {"shading", "gradient"})
        EXPECT_NE(std::ranges::find(json["idle_passes"], name), json["idle_passes"].end()) << name;
    EXPECT_EQ(json["asked"], Json({"image 'hit'", "image 'curvature'"}));
    EXPECT_EQ(json["look_bytes"], 0);
    EXPECT_TRUE(json["notes"].is_array());
    const ExrFile exr(folder / "a.exr");
    EXPECT_FALSE(exr.channels.contains("R"));
    EXPECT_TRUE(exr.channels.contains("curvature.flag"));

    more = {"--explain", "--set", "shading.show_environment=true", "--samples", "4"};
    const std::string text =
        checked_output(isocast(render("field:torus@16", folder / "a.png", more)));
    for (const char* words :
         {"asked for: beauty of 4 samples a pixel, environment as the background",
          "curvature                 -          -  nothing: does not run",
          // A column of 2048 texels of four halves, and its averages.
          "environment, maps and noise 0.03 MiB"})
        EXPECT_NE(text.find(words), std::string::npos) << words << " in " << text;
    EXPECT_EQ(isocast(render("field:torus@16", folder / "b.png", {"--no-beauty"})).code, 2);
    EXPECT_EQ(isocast(render("field:torus@16", folder / "b.exr", {"--no-beauty"})).code, 2);
}

TEST(Render, OpenExrHasCoverageOrTheEnvironment) {
    const TemporaryFolder folder;
    const auto draw = [&](std::vector<std::string> more) {
        more.insert(more.end(), {"--samples", "4"});
        checked_output(isocast(render("field:sphere@16", folder / "a.exr", more)));
        return ExrFile(folder / "a.exr").channels;
    };
    const auto covered = draw({});
    const auto around = draw({"--set", "shading.show_environment=true"});
    int edges = 0;
    for (std::size_t i = 0; i < covered.at("A").size(); ++i) {
        const float alpha = covered.at("A")[i];
        edges += alpha > 0 && alpha < 1;
        // Multiplied by coverage: no more than that share of the brightest colour, 1.25.
        EXPECT_LE(covered.at("R")[i], 1.25 * alpha);
        EXPECT_EQ(around.at("A")[i], 1);
        EXPECT_GT(around.at("B")[i], 0);
    }
    EXPECT_GT(edges, 20);
}

TEST(Render, ExplainsWhyItFetchesAsItDoes) {
    const TemporaryFolder folder;
    const auto text = [&](std::vector<std::string> more) {
        more.emplace_back("--explain");
        return checked_output(isocast(render("field:torus@16", folder / "a.png", more)));
    };
    // Osmesa's is a software rasteriser.
    EXPECT_NE(text({}).find("fetches rows: not measured"), std::string::npos);
    EXPECT_NE(text({"--fetch", "auto"}).find("fetches rows: not measured"), std::string::npos);
    EXPECT_NE(text({"--fetch", "linear"}).find("fetches linear: asked for"), std::string::npos);
    const Json json = Json::parse(checked_output(
        isocast(render("field:torus@16", folder / "a.png", {"--fetch", "samples", "--json"}))));
    EXPECT_EQ(json["fetch"], "samples");
}

TEST(Render, DerivativeFilterChangesTheShadingAlone) {
    const TemporaryFolder folder;
    const auto draw = [&](const std::string& name, std::vector<std::string> more) {
        more.insert(more.end(), {"--aov", "P"});
        checked_output(isocast(render("mesh:torus", folder / name, more)));
        return ExrFile(folder / name);
    };
    const ExrFile plain = draw("a.exr", {"--resolution", "24"});
    const ExrFile smooth = draw("b.exr", {"--resolution", "24", "--derivative-filter", "bspline"});
    for (const char* channel : {"P.X", "P.Y", "P.Z"})
        EXPECT_EQ(smooth.channels.at(channel), plain.channels.at(channel));
    EXPECT_NE(smooth.channels.at("R"), plain.channels.at("R"));
    EXPECT_EQ(plain.file.header().findTypedAttribute<Imf::StringAttribute>("derivativeFilter"),
              nullptr);
    EXPECT_EQ(smooth.file.header().typedAttribute<Imf::StringAttribute>("derivativeFilter").value(),
              "bspline");
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
    EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("filter").value(), "interpolating");
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
            // The interpolating B-spline errs by terms of fourth order, (h/r)^3 = 3e-4 voxels times
            // a small factor.
            EXPECT_NEAR(jet.value / voxel, 0, 1e-4);
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

TEST(Render, FiltersDifferAsTheyShould) {
    const TemporaryFolder folder;
    // The sphere's radius as each filter sees it, from the least depth: the eye is far, in the
    // middle.
    const auto radius = [&](const std::string& filter) {
        const std::string path = folder / "a.exr";
        checked_output(isocast(render(
            "field:sphere@24", path,
            {"--aov", "P", "--filter", filter, "--camera", "eye=0,0,9;target=0,0,0;height=2.5"})));
        const ExrFile exr(path);
        EXPECT_EQ(exr.file.header().typedAttribute<Imf::StringAttribute>("filter").value(), filter);
        double sum = 0;
        int count = 0;
        for (std::size_t i = 0; i < exr.channels.at("A").size(); ++i) {
            if (exr.channels.at("A")[i] == 0) continue;
            sum += exr.vector("P", i).norm();
            ++count;
        }
        return sum / count;
    };
    const double voxel = 2 * builtin_field("sphere").half_extent_world / 23;
    // In voxels, with h = 0.13 of the radius. The smoothing B-spline adds h^2/6 of the Laplacian,
    // 2/r: it shrinks the sphere by h/3 voxels. Third and fourth order: h^2 and h^3 times a small
    // factor. Linear cuts corners: a (1 - a)/2 of the second derivative along each axis, 1/12 on
    // average.
    EXPECT_NEAR((radius("bspline") - 1) / voxel, -voxel / 3, 2e-3);
    EXPECT_NEAR((radius("interpolating") - 1) / voxel, 0, 2e-3);
    EXPECT_NEAR((radius("exact") - 1) / voxel, 0, 2e-3);
    EXPECT_NEAR((radius("catmull-rom") - 1) / voxel, 0, 5e-3);
    EXPECT_NEAR((radius("linear") - 1) / voxel, -voxel / 6, 0.01);
}

TEST(Render, GuaranteeDecidesAboutGrazingRaysOnly) {
    const TemporaryFolder folder;
    const auto hits = [&](const char* guarantee) {
        checked_output(
            isocast(render("field:torus@24", folder / "a.exr", {"--guarantee", guarantee})));
        return ExrFile(folder / "a.exr").channels.at("A");
    };
    const std::vector<float> fine = hits("0.0001");
    const std::vector<float> coarse = hits("1");
    int fine_count = 0;
    int coarse_count = 0;
    for (std::size_t i = 0; i < fine.size(); ++i) {
        fine_count += fine[i] != 0;
        coarse_count += coarse[i] != 0;
        EXPECT_LE(coarse[i], fine[i]);
    }
    EXPECT_GT(fine_count, 200);
    // A chord of one voxel in a tube of radius 4 voxels ends 0.03 voxels from its silhouette;
    // pixels are half a voxel wide.
    EXPECT_GE(coarse_count, 0.9 * fine_count);
}

TEST(Render, TextureBudgetChangesNothingButTheLoading) {
    const TemporaryFolder folder;
    const auto bricks = [&](const char* mebibytes) {
        const Json json = Json::parse(checked_output(
            isocast(render("field:gyroid@48", folder / "a.exr",
                           {"--aov", "P,N", "--texture-memory", mebibytes, "--json"}))));
        return json["bricks"];
    };
    const Json all = bricks("100");
    const auto whole = ExrFile(folder / "a.exr").channels;
    EXPECT_EQ(all["resident"], all["active"]);
    EXPECT_EQ(all["loaded"], all["active"]);
    const Json few = bricks("0.5");
    EXPECT_EQ(few["active"], all["active"]);
    EXPECT_LT(few["resident"], all["active"]);
    EXPECT_EQ(ExrFile(folder / "a.exr").channels, whole);
}

TEST(Render, MemoryLimitChangesNothingButWhereSamplesLie) {
    const TemporaryFolder folder;
    const TemporaryFolder scratch;
    const std::string field = folder / "a.vdb";
    checked_output(isocast({"sample", "field:torus@48", "-o", field}));
    checked_output(isocast(render(field, folder / "a.png")));
    const Environment there{{"TMPDIR", scratch.path()}};
    const Outcome limited = isocast(render(field, folder / "b.png", {"--max-memory", "1K"}), there);
    EXPECT_EQ(limited.code, 0) << limited.err;
    EXPECT_EQ(contents_of(folder / "b.png"), contents_of(folder / "a.png"));
    EXPECT_EQ(scratch.entry_count(), 0);
    // That a scratch file was needed shows where there is no folder for it.
    const Environment nowhere{{"TMPDIR", scratch / "missing"}};
    const Outcome refused =
        isocast(render(field, folder / "c.png", {"--max-memory", "1K"}), nowhere);
    EXPECT_EQ(refused.code, 4);
    EXPECT_NE(refused.err.find("missing"), std::string::npos) << refused.err;
    EXPECT_EQ(isocast(render(field, folder / "c.png", {"--max-memory", "1G"}), nowhere).code, 0);
}

TEST(Render, CoarseBricksFitTheBudgetAndSaySo) {
    const TemporaryFolder folder;
    const auto draw = [&](const char* mebibytes) {
        return isocast(render(
            "field:gyroid@48", folder / "a.exr",
            {"--aov", "P", "--texture-memory", mebibytes, "--over-budget", "coarsen", "--json"}));
    };
    const Outcome all = draw("100");
    EXPECT_EQ(all.err, "");
    EXPECT_TRUE(Json::parse(checked_output(all))["coarse_bricks"].is_null());
    const auto whole = ExrFile(folder / "a.exr").channels;

    const Outcome few = draw("0.5");
    const Json json = Json::parse(checked_output(few));
    EXPECT_NE(few.err.find("bricks were coarsened"), std::string::npos) << few.err;
    EXPECT_EQ(json["warnings"].size(), 1u);
    const Json& coarse = json["coarse_bricks"];
    EXPECT_GT(coarse["count"], 0);
    EXPECT_LE(coarse["count"], coarse["of"]);
    EXPECT_EQ(coarse["of"], json["bricks"]["active"]);
    EXPECT_EQ(json["bricks"]["active"], json["bricks"]["resident"]);
    EXPECT_EQ(coarse["levels"].size(), 4u);
    EXPECT_GT(coarse["greatest_residual"], 0.0);
    EXPECT_NE(ExrFile(folder / "a.exr").channels, whole);

    const std::string text = checked_output(
        isocast(render("field:gyroid@48", folder / "a.png",
                       {"--texture-memory", "0.5", "--over-budget", "coarsen", "--explain"})));
    EXPECT_NE(text.find("bricks of 8^3 cells"), std::string::npos) << text;
}

TEST(Render, FileWithoutAnIsoValueIsDrawnAtTheSuggestedOne) {
    const TemporaryFolder folder;
    checked_output(isocast({"sample", "field:marschner-lobb@20", "-o", folder / "a.vdb"}));
    const Json info = Json::parse(checked_output(isocast({"info", folder / "a.vdb", "--json"})));
    const double iso = info["grids"][0]["suggested_iso"];
    const auto picture = [&](const std::vector<std::string>& more) {
        checked_output(
            isocast(render(folder / "a.vdb", folder / "a.exr", joined({"--aov", "P"}, more))));
        const ExrFile exr(folder / "a.exr");
        return std::pair(exr.file.header().typedAttribute<Imf::FloatAttribute>("iso").value(),
                         exr.channels);
    };
    const auto suggested = picture({});
    EXPECT_EQ(suggested.first, static_cast<float>(iso));
    EXPECT_EQ(suggested, picture({"--iso", fmt::format("{}", iso)}));
}

TEST(Render, IsTheSameEveryTime) {
    const TemporaryFolder folder;
    for (const char* name : {"a.png", "b.png"})
        checked_output(isocast(render("field:gyroid@16", folder / name, {"--repeat", "2"})));
    EXPECT_EQ(contents_of(folder / "a.png"), contents_of(folder / "b.png"));
}

} // namespace
} // namespace isocast::test
