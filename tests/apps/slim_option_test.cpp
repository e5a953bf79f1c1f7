// `convert -o X.slim` and `info X.slim`.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "program.h"
#include "quadrics/slim_file.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>

namespace isocast::test {
namespace {

using Json = nlohmann::json;

struct ConvertToSlim : testing::Test {
    TemporaryFolder folder;
    Outcome convert(const std::vector<std::string>& more) {
        return isocast(joined({"convert", "mesh:torus"}, more));
    }
};

TEST_F(ConvertToSlim, ReportsWhatTheFileHolds) {
    const Json made = Json::parse(checked_output(convert({"-o", folder / "a.slim", "--json"})));
    const SlimSurface surface = read_slim(folder / "a.slim");
    EXPECT_EQ(made["patches"], surface.patch_count());
    EXPECT_EQ(made["levels"].size(), surface.levels.size());
    EXPECT_EQ(made["over_bound"], 0);
    EXPECT_LE(made["greatest_error"], made["max_error"]);
    EXPECT_GT(made["patches"], 10);
    EXPECT_LT(made["patches"], made["triangles"]);
    const Json info = Json::parse(checked_output(isocast({"info", folder / "a.slim", "--json"})));
    EXPECT_EQ(info["patches"], made["patches"]);
    for (std::size_t i = 0; i < surface.levels.size(); ++i) {
        EXPECT_EQ(made["levels"][i]["patches"], surface.levels[i].patches.size());
        EXPECT_EQ(info["levels"][i]["patches"], surface.levels[i].patches.size());
        EXPECT_EQ(info["levels"][i]["max_error"], surface.levels[i].max_error_world);
    }
    EXPECT_EQ(info["closed"], true);
    EXPECT_EQ(info["max_error"], made["max_error"]);
}

TEST_F(ConvertToSlim, ErrorIsAPartOfTheDiagonal) {
    const auto max_error = [&](const char* share) {
        checked_output(convert({"-o", folder / "a.slim", "--max-error", share}));
        return read_slim(folder / "a.slim").levels.front().max_error_world;
    };
    EXPECT_NEAR(max_error("1e-2") / max_error("2e-3"), 5, 1e-12); // roundings of two products
    EXPECT_EQ(convert({"-o", folder / "b.slim", "--max-error", "0"}).code, 2);
    EXPECT_EQ(convert({"-o", folder / "b.slim", "--max-error", "1"}).code, 2);
}

TEST_F(ConvertToSlim, RefusesWhatOnlyFieldsHave) {
    for (const char* option : {"--closest", "--dry-run"})
        EXPECT_EQ(convert({"-o", folder / "a.slim", option}).code, 2) << option;
    EXPECT_EQ(convert({"-o", folder / "a.slim", "--resolution", "64"}).code, 2);
    EXPECT_EQ(convert({"-o", folder / "a.slim", "--method", "octree"}).code, 2);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.slim"));
}

TEST_F(ConvertToSlim, TakesPointsAlone) {
    const Json made = Json::parse(
        checked_output(convert({"--method", "points", "-o", folder / "a.slim", "--json"})));
    const SlimSurface surface = read_slim(folder / "a.slim");
    EXPECT_GT(made["points"], 100);
    EXPECT_EQ(made["normals"], "given");
    EXPECT_FALSE(made.contains("triangles"));
    EXPECT_EQ(made["patches"], surface.patch_count());
    EXPECT_GT(surface.levels.front().patches.size(), 10U);
    EXPECT_FALSE(surface.is_closed);
    for (const std::vector<std::string>& wrong :
         {std::vector<std::string>{"--approximation", "1"}, {"--point-method", "mls"}})
        EXPECT_EQ(convert(joined({"--method", "points", "-o", folder / "b.slim"}, wrong)).code, 2);
    std::ofstream(folder / "few.xyz") << "0 0 0\n1 0 0\n0 1 0\n";
    EXPECT_EQ(
        isocast({"convert", folder / "few.xyz", "--method", "points", "-o", folder / "b.slim"})
            .code,
        3);
    EXPECT_FALSE(std::filesystem::exists(folder / "b.slim"));
}

TEST_F(ConvertToSlim, DamagedFilesAreRefused) {
    std::ofstream(folder / "a.slim") << "isoSLIM\n and no more";
    EXPECT_EQ(isocast({"info", folder / "a.slim"}).code, 3);
    EXPECT_EQ(isocast({"info", folder / "none.slim"}).code, 3);
}

} // namespace
} // namespace isocast::test
