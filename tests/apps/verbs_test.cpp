// What the verbs write and report when all is well; drawing has a file of its own.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "program.h"
#include "volume/files.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace isocast::test {
namespace {

using Json = nlohmann::json;

Json json_of(const std::vector<std::string>& arguments, const Environment& environment = {}) {
    const Outcome outcome = isocast(arguments, environment);
    EXPECT_EQ(outcome.err, "");
    return Json::parse(checked_output(outcome));
}

void expect_keys(const Json& json, const std::vector<std::string>& keys) {
    for (const std::string& key : keys) EXPECT_TRUE(json.contains(key)) << key << " in " << json;
}

TEST(Convert, JsonHasTheDocumentedKeys) {
    const TemporaryFolder folder;
    const Json json =
        json_of({"convert", "mesh:knot", "-o", folder / "a.vdb", "--resolution", "48", "--json"});
    expect_keys(json, {"input", "triangles", "verdict", "sign", "voxel_size", "half_width_voxels",
                       "active_voxels", "seconds", "peak_bytes", "warnings"});
    expect_keys(json["verdict"],
                {"summary", "closed", "oriented", "manifold", "reversed", "unreferenced_vertices",
                 "duplicate_vertices", "degenerate_triangles", "duplicate_triangles",
                 "boundary_edges", "boundary_loops", "non_manifold_edges", "flipped_edges",
                 "non_manifold_vertices", "shells", "volume"});
    expect_keys(json["seconds"], {"read", "prepare", "transform", "write", "total"});
    EXPECT_EQ(json["input"], "mesh:knot");
    EXPECT_EQ(json["triangles"], 2880);
    EXPECT_EQ(json["sign"], "normal");
    EXPECT_TRUE(json["verdict"]["closed"]);
    EXPECT_TRUE(json["warnings"].empty());
    // At least the program itself, at most what any machine has.
    EXPECT_GT(json["peak_bytes"], 1 << 20);
}

TEST(Convert, ResolutionIsVoxelsAlongTheLongestSide) {
    const TemporaryFolder folder;
    const Json json = json_of(
        {"convert", "mesh:sphere6", "-o", folder / "a.vdb", "--resolution", "50", "--json"});
    // The unit sphere's box has sides of exactly 2: the octahedron's corners are on the axes.
    EXPECT_DOUBLE_EQ(json["voxel_size"], 2.0 / 50);
}

TEST(Convert, BandInWorldUnitsEqualsTheSameBandInVoxels) {
    const TemporaryFolder folder;
    const std::vector<std::string> common{"convert", "mesh:knot", "--voxel-size", "0.125",
                                          "--json"};
    auto in_voxels = common, in_world = common;
    in_voxels.insert(in_voxels.end(), {"--band", "4", "-o", folder / "a.vdb"});
    in_world.insert(in_world.end(), {"--band-world", "0.5", "-o", folder / "b.vdb"});
    const Json a = json_of(in_voxels), b = json_of(in_world);
    EXPECT_EQ(a["half_width_voxels"], 4.0);
    EXPECT_EQ(b["half_width_voxels"], 4.0);
    EXPECT_EQ(a["active_voxels"], b["active_voxels"]);
}

TEST(Convert, WritesWhatItReports) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.vdb";
    const Json json =
        json_of({"convert", "mesh:torus", "-o", path, "--resolution", "40", "--json"});
    const auto grids = describe_field_file(path);
    ASSERT_EQ(grids.size(), 1u);
    EXPECT_EQ(grids[0].name, "surface");
    EXPECT_EQ(grids[0].grid_class, "level set");
    EXPECT_EQ(grids[0].active_voxels, json["active_voxels"]);
    // The background is stored as float32.
    EXPECT_FLOAT_EQ(float(grids[0].background_world), float(3 * json["voxel_size"].get<double>()));
    EXPECT_EQ(grids[0].metadata.at("source"), "mesh:torus");
    EXPECT_EQ(grids[0].metadata.at("sign_method"), "normal");
    EXPECT_TRUE(grids[0].metadata.at("creator").starts_with("isocast "));
}

TEST(Convert, DoesNotDependOnTheNumberOfThreads) {
    const TemporaryFolder folder;
    const auto field = [&](const std::string& threads) {
        const std::string path = folder / (threads + ".vdb");
        checked_output(isocast(
            {"convert", "mesh:knot", "-o", path, "--resolution", "64", "--threads", threads}));
        return read_field(path);
    };
    const auto one = field("1"), many = field("7");
    ASSERT_EQ(one->extent(), many->extent());
    const auto count = static_cast<std::size_t>(one->extent().sample_count());
    std::vector<float> a(count), b(count);
    one->copy_box(one->extent(), 0, a);
    many->copy_box(many->extent(), 0, b);
    EXPECT_EQ(a, b);
}

TEST(Convert, WarnsOnStderrOfAnOpenMesh) {
    const TemporaryFolder folder;
    Mesh mesh = sample_mesh("torus");
    mesh.triangles.resize(mesh.triangles.size() - 10);
    write_mesh(mesh, folder / "open.ply");
    const Outcome outcome = isocast(
        {"convert", folder / "open.ply", "-o", folder / "a.vdb", "--resolution", "24", "--json"});
    const Json json = Json::parse(checked_output(outcome));
    EXPECT_FALSE(json["verdict"]["closed"]);
    EXPECT_EQ(json["sign"], "winding");
    ASSERT_FALSE(json["warnings"].empty());
    for (const Json& warning : json["warnings"])
        EXPECT_NE(outcome.err.find(warning.get<std::string>()), std::string::npos) << outcome.err;
}

TEST(Convert, NeedsNoOpenGl) {
    const TemporaryFolder folder;
    json_of(
        {"convert", "mesh:knot", "-o", folder / "a.vdb", "--resolution", "16", "--json"},
        {{"MESA_GL_VERSION_OVERRIDE", "2.1"}, {"__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent"}});
    // The program starts where no such library is installed: nothing that it links needs one.
    const std::string libraries = checked_output(run("ldd", {ISOCAST_PROGRAM}));
    for (const char* name : {"libGL.so", "libEGL.so", "libOSMesa.so", "libOpenGL.so"})
        EXPECT_EQ(libraries.find(name), std::string::npos) << name;
}

TEST(Convert, WritesALevelSetForOtherPrograms) {
    if (run("bash", {"-c", "command -v vdb_print"}).code != 0)
        GTEST_SKIP() << "vdb_print (libopenvdb-tools) is not installed";
    const TemporaryFolder folder;
    checked_output(isocast({"convert", "mesh:knot", "-o", folder / "a.vdb", "--resolution", "32"}));
    const std::string text = checked_output(run("vdb_print", {"-l", folder / "a.vdb"}));
    EXPECT_NE(text.find("Name: surface"), std::string::npos) << text;
    EXPECT_NE(text.find("class: level set"), std::string::npos) << text;
}

TEST(Convert, ReplacesAnOlderFile) {
    const TemporaryFolder folder;
    write_text(folder / "a.vdb", "old");
    checked_output(isocast({"convert", "mesh:knot", "-o", folder / "a.vdb", "--resolution", "16"}));
    EXPECT_TRUE(isocast({"info", folder / "a.vdb"}).out.find("surface") != std::string::npos);
    EXPECT_EQ(folder.entry_count(), 1);
}

TEST(Convert, RealScan) {
    const std::filesystem::path scan = ISOCAST_SHARED_DATA "/bunny-closed.obj";
    if (!std::filesystem::exists(scan)) GTEST_SKIP() << "no " << scan;
    const TemporaryFolder folder;
    const Json json =
        json_of({"convert", scan, "-o", folder / "a.vdb", "--resolution", "64", "--json"});
    EXPECT_TRUE(json["verdict"]["closed"]);
    EXPECT_EQ(json["sign"], "normal");
}

TEST(Info, DescribesMeshesFieldsAndFiles) {
    const TemporaryFolder folder;
    const Json mesh = json_of({"info", "mesh:sphere6", "--json"});
    expect_keys(mesh, {"input", "kind", "vertices", "triangles", "box", "verdict", "warnings"});
    // An octahedron subdivided six times.
    EXPECT_EQ(mesh["vertices"], 16386);
    EXPECT_EQ(mesh["box"]["max"], Json({1, 1, 1}));

    const Json field = json_of({"info", "field:gyroid@20", "--json"});
    expect_keys(field,
                {"input", "kind", "voxel_size", "world_from_index", "samples", "value_range"});
    EXPECT_EQ(field["samples"], Json({20, 20, 20}));

    checked_output(isocast({"sample", "field:gyroid@20", "-o", folder / "a.vdb"}));
    const Json file = json_of({"info", folder / "a.vdb", "--json"});
    ASSERT_EQ(file["grids"].size(), 1u);
    expect_keys(file["grids"][0], {"name", "class", "type", "voxel_size", "world_from_index",
                                   "background", "active_voxels", "active_box", "metadata"});
    EXPECT_EQ(file["grids"][0]["active_voxels"], 20 * 20 * 20);
    EXPECT_EQ(file["grids"][0]["world_from_index"], field["world_from_index"]);
    EXPECT_EQ(json_of({"info", (folder / "a.vdb").string() + ":surface", "--json"})["grids"],
              file["grids"]);

    for (const std::string& input :
         {std::string("mesh:knot"), std::string("field:cube@8"), (folder / "a.vdb").string()})
        EXPECT_NE(checked_output(isocast({"info", input})).find(input), std::string::npos);
}

TEST(Info, DescribesVolumes) {
    const TemporaryFolder folder;
    // 16^3 bytes: 20 where x < 8, else 120.
    std::string samples;
    for (int i = 0; i < 16 * 16 * 16; ++i) samples.push_back(i % 16 < 8 ? 20 : 120);
    write_text(folder / "a.mha", "NDims = 3\nDimSize = 16 16 16\nElementType = MET_UCHAR\n"
                                 "ElementSpacing = 1 2 3\nOffset = 10 20 30\n"
                                 "ElementDataFile = LOCAL\n" +
                                     samples);
    const Json file = json_of({"info", folder / "a.mha", "--json"});
    EXPECT_EQ(file["kind"], "field");
    ASSERT_EQ(file["grids"].size(), 1u);
    const Json& grid = file["grids"][0];
    expect_keys(grid, {"name", "class", "type", "voxel_size", "spacing", "size", "world_box",
                       "world_from_index", "value_range", "value_range_is_exact", "histogram",
                       "suggested_iso", "suggested_iso_reason", "metadata"});
    EXPECT_EQ(grid["class"], "dense");
    EXPECT_EQ(grid["type"], "uint8");
    EXPECT_EQ(grid["size"], Json({16, 16, 16}));
    EXPECT_EQ(grid["spacing"], Json({1, 2, 3}));
    EXPECT_EQ(grid["world_box"]["min"], Json({10, 20, 30}));
    EXPECT_EQ(grid["world_box"]["max"], Json({25, 50, 75}));
    EXPECT_EQ(grid["value_range"], Json({20, 120}));
    const Json& histogram = grid["histogram"];
    EXPECT_EQ(histogram["edges"].size(), histogram["counts"].size() + 1);
    EXPECT_LE(histogram["counts"].size(), 64u);
    EXPECT_EQ(histogram["samples"], 4096);
    EXPECT_EQ(histogram["counts"].front(), 2048);
    EXPECT_EQ(histogram["counts"].back(), 2048);
    EXPECT_NEAR(grid["suggested_iso"], 70, 1);

    const std::string report = checked_output(isocast({"info", folder / "a.mha"}));
    for (const char* words :
         {"uint8", "(1, 2, 3)", "(10, 20, 30)", "20 ... 120", "##", "2048", "suggested iso 70"})
        EXPECT_NE(report.find(words), std::string::npos) << words << " in " << report;
}

TEST(Info, SuggestsTheSurfaceOfDistances) {
    const TemporaryFolder folder;
    const auto suggested = [](const std::string& input) {
        return json_of({"info", input, "--json"})["grids"][0]["suggested_iso"];
    };
    checked_output(
        isocast({"convert", "mesh:torus", "-o", folder / "a.vdb", "--resolution", "32"}));
    EXPECT_EQ(suggested(folder / "a.vdb"), 0);
    checked_output(
        isocast({"convert", "mesh:torus", "-o", folder / "a.nrrd", "--resolution", "32"}));
    EXPECT_EQ(suggested(folder / "a.nrrd"), 0);
    checked_output(isocast({"convert", "mesh:torus", "-o", folder / "b.vdb", "--voxel-size",
                            "0.125", "--sign", "unsigned"}));
    EXPECT_EQ(suggested(folder / "b.vdb"), 0.125);
    EXPECT_EQ(json_of({"info", "field:gyroid@20", "--json"})["suggested_iso"], 0);
}

TEST(Info, OfAHeadSuggestsItsSkin) {
    const std::string head = "/usr/share/mricron/templates/ch2.nii.gz";
    if (!std::filesystem::exists(head)) GTEST_SKIP() << "no " << head << " (mricron-data)";
    const Json grid = json_of({"info", head, "--json"})["grids"][0];
    EXPECT_EQ(grid["size"], Json({181, 217, 181}));
    EXPECT_FALSE(grid["histogram"]["samples"] == grid["histogram"]["samples_in_field"]);
    EXPECT_TRUE(grid["value_range_is_exact"]);
    // Between air (below 10) and tissue (80 and above).
    EXPECT_GT(grid["suggested_iso"], 20);
    EXPECT_LT(grid["suggested_iso"], 90);
}

TEST(Sample, EveryListedNameCanBeWrittenAndRead) {
    const TemporaryFolder folder;
    const Json names = json_of({"sample", "--list", "--json"})["names"];
    EXPECT_GE(names.size(), 11u); // DESIGN section 5 and the headers name four meshes, seven fields
    const std::string list = checked_output(isocast({"sample", "--list"}));
    for (const std::string name : names) {
        EXPECT_NE(list.find(name + "\n"), std::string::npos);
        const bool is_mesh = name.starts_with("mesh:");
        const std::string path = folder / (is_mesh ? "a.ply" : "a.vdb");
        checked_output(isocast({"sample", is_mesh ? name : name + "@9", "-o", path}));
        json_of({"info", path, "--json"});
    }
}

TEST(Sample, MeshFilesHoldTheMesh) {
    const TemporaryFolder folder;
    for (const char* file : {"a.obj", "a.ply", "a.off"}) {
        checked_output(isocast({"sample", "mesh:knot", "-o", folder / file}));
        const Mesh mesh = read_mesh(folder / file);
        EXPECT_EQ(mesh.vertices_world, sample_mesh("knot").vertices_world) << file;
        EXPECT_EQ(mesh.triangles, sample_mesh("knot").triangles) << file;
    }
}

TEST(Help, IsGivenByTheProgramAndEachVerb) {
    for (const std::vector<std::string>& verb :
         std::vector<std::vector<std::string>>{{}, {"convert"}, {"render"}, {"info"}, {"sample"}}) {
        auto with_help = verb, with_version = verb;
        with_help.push_back("--help");
        with_version.push_back("--version");
        const std::string help = checked_output(isocast(with_help));
        EXPECT_NE(help.find("Usage: isocast"), std::string::npos) << help;
        EXPECT_NE(help.find("Exit codes: 0 ok, 1 failed, 2 usage, 3 bad input"), std::string::npos);
        EXPECT_NE(help.find("Example: isocast "), std::string::npos) << help;
        EXPECT_TRUE(checked_output(isocast(with_version)).starts_with("isocast "));
    }
}

} // namespace
} // namespace isocast::test
