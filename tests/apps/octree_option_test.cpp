// `convert --method octree`: octree files, what is reported of them, what becomes of them.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "program.h"
#include "volume/files.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace isocast::test {
namespace {

using Json = nlohmann::json;

struct ConvertOctreeVerb : testing::Test {
    TemporaryFolder folder;
    Outcome convert(const std::vector<std::string>& more) {
        return isocast(joined({"convert", "mesh:sphere6", "--method", "octree"}, more));
    }
};

TEST_F(ConvertOctreeVerb, KeepsTheErrorThroughFilesOfBothKinds) {
    const Json json = Json::parse(
        checked_output(convert({"--max-error", "0.01", "-o", folder / "a.hoct", "--json"})));
    EXPECT_EQ(json["octree"]["max_error"], 0.01);
    EXPECT_GT(json["octree"]["sampled_nodes"], 0);
    EXPECT_TRUE(json["warnings"].empty());
    const Json info = Json::parse(checked_output(isocast({"info", folder / "a.hoct", "--json"})));
    EXPECT_NE(info.dump().find("mesh:sphere6"), std::string::npos); // the source
    checked_output(isocast({"convert", folder / "a.hoct", "-o", folder / "a.vdb"}));
    for (const char* name : {"a.hoct", "a.vdb"}) {
        const auto field = read_field(folder / name);
        std::vector<float> value(1);
        // Where the unit sphere's mesh crosses the axes: its vertices, to its own 1e-3.
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {-1.0, 1.0}) {
                const Vec3d p = field->space().to_index(side * Vec3d::Unit(axis));
                const Index3 at = p.array().round().cast<int>().matrix();
                field->copy_box({at, (at.array() + 1).matrix()}, 0, value);
                const double exact = field->space().to_world(at.cast<double>()).norm() - 1;
                EXPECT_NEAR(value[0], exact, 0.01 + 1e-3) << name;
            }
    }
}

TEST_F(ConvertOctreeVerb, IsDrawn) {
    checked_output(convert({"--max-error", "0.01", "-o", folder / "a.hoct"}));
    const Json json = Json::parse(checked_output(isocast(
        {"render", folder / "a.hoct", "-o", folder / "a.png", "--size", "64x64", "--json"})));
    EXPECT_GT(json["bricks"]["active"], 0);
}

TEST_F(ConvertOctreeVerb, LevelsBecomeGrids) {
    checked_output(convert({"--max-error", "0.02", "-o", folder / "a.vdb", "--grids", "levels"}));
    const auto grids = describe_field_file(folder / "a.vdb");
    ASSERT_GT(grids.size(), 2U);
    EXPECT_EQ(grids[0].name, "surface_level_0");
    EXPECT_NEAR(grids[1].world_from_index.linear()(0, 0),
                2 * grids[0].world_from_index.linear()(0, 0), 1e-12);
}

TEST_F(ConvertOctreeVerb, RefusesWhatItCannotDoAndLeavesNoFile) {
    EXPECT_EQ(convert({"--max-error", "0", "-o", folder / "a.hoct"}).code, 3);
    EXPECT_EQ(convert({"--max-error", "1e-30", "-o", folder / "a.hoct"}).code, 4);
    EXPECT_EQ(convert({"-o", folder / "a.nrrd"}).code, 2);
    EXPECT_EQ(convert({"--extend", "full", "-o", folder / "a.hoct"}).code, 2);
    EXPECT_EQ(convert({"--max-memory", "1M", "-o", folder / "a.hoct"}).code, 4);
    EXPECT_EQ(
        isocast({"convert", "mesh:knot", "--interpolation", "cubic", "-o", folder / "a.vdb"}).code,
        2);
    EXPECT_EQ(folder.entry_count(), 0);
}

} // namespace
} // namespace isocast::test
