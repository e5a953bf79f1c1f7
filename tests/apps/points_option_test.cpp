// `convert --method points`: files of points, what is reported, and what is refused.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "program.h"
#include "volume/files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace isocast::test {
namespace {

using Json = nlohmann::json;

/// Points of the unit sphere along a spiral, as XYZ text.
std::string spiral(int count, bool with_normals) {
    std::string text = "# x y z\n";
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1) / static_cast<double>(count);
        const double turn = 2.399963229728653 * i; // the golden angle
        const double r = std::sqrt(1 - z * z);
        const std::string p = fmt::format("{} {} {}", r * std::cos(turn), r * std::sin(turn), z);
        text += with_normals ? fmt::format("{} {}\n", p, p) : p + "\n";
    }
    return text;
}

struct ConvertPointsVerb : testing::Test {
    TemporaryFolder folder;
    std::string cloud(const std::string& name, const std::string& text) {
        write_text(folder / name, text);
        return folder / name;
    }
    Outcome convert(const std::string& input, const std::vector<std::string>& more) {
        return isocast(joined(
            {"convert", input, "--method", "points", "--resolution", "32", "-o", folder / "a.vdb"},
            more));
    }
};

TEST_F(ConvertPointsVerb, XyzIsACloudAndTheFieldASphere) {
    const Json json =
        Json::parse(checked_output(convert(cloud("a.xyz", spiral(1000, true)), {"--json"})));
    EXPECT_EQ(json["points"], 1000);
    EXPECT_EQ(json["normals"], "given");
    EXPECT_NEAR(json["spacing"].get<double>(), std::sqrt(4 * 3.14159265 / 1000), 0.01);
    EXPECT_TRUE(json["warnings"].empty());
    EXPECT_FALSE(json.contains("verdict"));
    const auto field = read_field(folder / "a.vdb");
    const double voxel = field->space().voxel_size_world();
    std::vector<float> value(1);
    for (int i = 14; i <= 18; ++i) { // along x through the surface; the sphere is about the origin
        field->copy_box({Index3(i, 0, 0), Index3(i + 1, 1, 1)}, 0, value);
        EXPECT_NEAR(value[0], i * voxel - 1, 0.1 * voxel); // as bench_points: RMS 0.02 voxel
    }
}

TEST_F(ConvertPointsVerb, MissingNormalsAreEstimatedWithAWarning) {
    const Outcome outcome = convert(cloud("a.xyz", spiral(1000, false)), {"--json"});
    const Json json = Json::parse(outcome.out);
    EXPECT_EQ(json["normals"], "estimated");
    EXPECT_EQ(json["warnings"].size(), 1u);
    EXPECT_NE(outcome.err.find("no normals"), std::string::npos);
}

TEST_F(ConvertPointsVerb, DryRunEstimates) {
    const Json json = Json::parse(
        checked_output(convert(cloud("a.xyz", spiral(1000, true)), {"--dry-run", "--json"})));
    EXPECT_GT(json["expected"]["active_voxels"], 1000);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.vdb"));
}

TEST_F(ConvertPointsVerb, WhatCannotBeIsRefused) {
    const std::string few = cloud("few.xyz", spiral(10, true));
    const std::string enough = cloud("a.xyz", spiral(100, true));
    const auto expect = [&](int code, const Outcome& outcome, const std::string& words) {
        EXPECT_EQ(outcome.code, code);
        EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
        EXPECT_FALSE(std::filesystem::exists(folder / "a.vdb"));
    };
    expect(3, convert(few, {}), "few.xyz: 10 points are too few to look at 20 neighbours");
    expect(3, convert(enough, {"--approximation", "-1"}), "approximation of -1");
    expect(2, convert(enough, {"--point-method", "kriging"}), "known: partition");
    expect(2, convert(enough, {"--extend", "full"}), "no --extend");
    expect(2, convert(enough, {"--sign", "winding"}), "no --extend, --sign");
    expect(2, isocast({"convert", "mesh:knot", "-o", folder / "a.vdb", "--neighbours", "9"}),
           "need --method points");
    expect(3, isocast({"convert", enough, "-o", folder / "a.vdb"}), "a mesh is needed");
}

} // namespace
} // namespace isocast::test
