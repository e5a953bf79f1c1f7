// `isocast convert --repair`, with and without CGAL.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "program.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace isocast::test {
namespace {

#ifdef ISOCAST_WITH_REPAIR
TEST(RepairOption, ClosesAnOpenMeshAndSaysSo) {
    const TemporaryFolder folder;
    Mesh open = sample_mesh("knot");
    open.triangles.pop_back();
    write_mesh(open, folder / "open.ply");
    const Outcome outcome = isocast({"convert", folder / "open.ply", "-o", folder / "a.vdb",
                                     "--resolution", "32", "--repair", "--json"});
    const auto json = nlohmann::json::parse(checked_output(outcome));
    EXPECT_TRUE(json["verdict"]["closed"]);
    EXPECT_EQ(json["sign"], "normal");
    EXPECT_NE(outcome.err.find("1 of 1 holes filled with 1 triangles; closed"), std::string::npos)
        << outcome.err;
}
#else
TEST(RepairOption, SaysHowToGetItWhereItIsMissing) {
    const TemporaryFolder folder;
    const Outcome outcome = isocast({"convert", "mesh:knot", "-o", folder / "a.vdb", "--repair"});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find("-DISOCAST_REPAIR=ON"), std::string::npos) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "a.vdb"));
}
#endif

} // namespace
} // namespace isocast::test
