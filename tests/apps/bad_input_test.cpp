// Every bad input: one line that names the file and the cause, the documented exit code, no output.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "program.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <algorithm>

namespace isocast::test {
namespace {

struct Refused : testing::Test {
    TemporaryFolder folder;
    TemporaryFolder results;
    std::string out(const std::string& name) const { return results / name; }
    std::string input(const std::string& name, const std::string& text) const {
        write_text(folder / name, text);
        return folder / name;
    }

    /// The run ends with `code` and one line on stderr that holds all `words`; it says nothing on
    /// stdout and leaves nothing in the folder of results.
    void expect(int code, const Outcome& outcome, const std::vector<std::string>& words) const {
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_EQ(outcome.out, "");
        EXPECT_TRUE(outcome.err.starts_with("isocast: ")) << outcome.err;
        EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
        EXPECT_TRUE(outcome.err.ends_with('\n')) << outcome.err;
        for (const std::string& word : words)
            EXPECT_NE(outcome.err.find(word), std::string::npos)
                << "no '" << word << "' in: " << outcome.err;
        EXPECT_EQ(results.entry_count(), 0);
    }
    /// The same, of converting the mesh `path`.
    void expect_bad_mesh(const std::string& path, const std::vector<std::string>& words) const {
        std::vector<std::string> all = words;
        all.push_back(std::filesystem::path(path).filename());
        expect(3, isocast({"convert", path, "-o", out("a.vdb"), "--resolution", "16"}), all);
        expect(3, isocast({"info", path}), all);
        expect(3, isocast({"render", path, "-o", out("a.png")}), all);
    }
    /// The same, of drawing the field `path`.
    void expect_bad_field(const std::string& path, const std::vector<std::string>& words) const {
        expect(3, isocast({"render", path, "-o", out("a.png")}), words);
    }
};

using RefusedMesh = Refused;
using RefusedField = Refused;
using RefusedOption = Refused;
using RefusedOutput = Refused;

constexpr const char* ply_header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                                   "property float y\nproperty float z\nelement face 1\n"
                                   "property list uchar int vertex_indices\nend_header\n";

TEST_F(RefusedMesh, MissingFile) {
    expect_bad_mesh(folder / "nowhere.obj", {"no such file"});
}

TEST_F(RefusedMesh, TruncatedPly) {
    expect_bad_mesh(input("cut.ply", ply_header + std::string("0 0 0\n1 0 0\n")), {});
}

TEST_F(RefusedMesh, TruncatedBinaryPly) {
    std::string header = ply_header;
    header.replace(header.find("ascii"), 5, "binary_little_endian");
    expect_bad_mesh(input("cut.ply", header + std::string(30, '\0')), {});
}

TEST_F(RefusedMesh, CoordinateThatIsNoNumber) {
    expect_bad_mesh(input("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n"), {"2"});
}

TEST_F(RefusedMesh, IndexOutOfRange) {
    expect_bad_mesh(input("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), {"4"});
}

TEST_F(RefusedMesh, NoTriangles) {
    expect_bad_mesh(input("empty.obj", ""), {});
    expect_bad_mesh(input("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), {});
}

TEST_F(RefusedMesh, OnlyDegenerateTriangles) {
    expect_bad_mesh(input("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), {});
}

TEST_F(RefusedMesh, UnknownExtension) {
    expect_bad_mesh(input("mesh.xyzzy", "v 0 0 0\n"), {".vdb", ".obj"});
}

TEST_F(RefusedMesh, UnknownBuiltinName) {
    expect(3, isocast({"convert", "mesh:teapot", "-o", out("a.vdb")}),
           {"'teapot'", "sphere6", "torus", "knot", "seashell"});
    expect(3, isocast({"sample", "mesh:teapot", "-o", out("a.obj")}), {"'teapot'", "knot"});
    expect(3, isocast({"sample", "teapot", "-o", out("a.obj")}), {"'teapot'", "--list"});
}

TEST_F(RefusedMesh, FieldWhereAMeshIsNeeded) {
    expect(3, isocast({"convert", "field:torus@16", "-o", out("a.vdb")}), {"field:torus@16"});
}

TEST_F(RefusedField, NoFloatGrid) {
    openvdb::initialize();
    auto velocity = openvdb::Vec3SGrid::create();
    velocity->setName("velocity");
    velocity->fill({{0, 0, 0}, {3, 3, 3}}, openvdb::Vec3s(1, 0, 0));
    openvdb::io::File(folder / "vectors.vdb").write({velocity});
    expect_bad_field(folder / "vectors.vdb", {"vectors.vdb", "float", "velocity", "vec3s"});
}

TEST_F(RefusedField, UnknownGrid) {
    checked_output(isocast({"sample", "field:torus@16", "-o", folder / "a.vdb"}));
    expect_bad_field((folder / "a.vdb").string() + ":density", {"a.vdb", "density", "surface"});
    expect(3, isocast({"info", (folder / "a.vdb").string() + ":density"}),
           {"a.vdb", "density", "surface"});
}

TEST_F(RefusedField, FileThatIsNoVdb) {
    expect_bad_field(input("text.vdb", "not a grid"), {"text.vdb"});
    expect_bad_field(input("empty.vdb", ""), {"empty.vdb"});
}

TEST_F(RefusedField, TruncatedVdb) {
    checked_output(isocast({"sample", "field:torus@32", "-o", folder / "a.vdb"}));
    const std::string whole = contents_of(folder / "a.vdb");
    expect_bad_field(input("cut.vdb", whole.substr(0, whole.size() / 2)), {"cut.vdb"});
}

TEST_F(RefusedField, VolumeThatIsTruncatedOrUnknown) {
    const std::string header = "NDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\n";
    const auto expect_bad_volume = [&](const std::string& path,
                                       const std::vector<std::string>& words) {
        expect_bad_field(path, words);
        expect(3, isocast({"info", path}), words);
    };
    expect_bad_volume(input("cut.mha", header + "ElementDataFile = LOCAL\n123"),
                      {"cut.mha", "truncated", "64 bytes"});
    expect_bad_volume(input("beside.mhd", header + "ElementDataFile = none.raw\n"),
                      {"none.raw", "No such file"});
    expect_bad_volume(input("text.nrrd", "not a grid"), {"text.nrrd", "not an NRRD file"});
    expect_bad_volume(input("text.nii", "not a grid"), {"text.nii", "not a NIfTI file"});
    expect_bad_volume(input("text.nii.gz", "not a grid"), {"text.nii.gz"});
}

TEST_F(RefusedField, VolumeWithASampleThatIsNoNumber) {
    std::string samples(4 * 4 * 4 * 4, '\0');
    samples.replace(4 * (1 + 4 * (2 + 4 * 3)), 4, std::string("\0\0\xc0\x7f", 4)); // NaN
    const std::string path =
        input("nan.mha", "NDims = 3\nDimSize = 4 4 4\nElementType = MET_FLOAT\n"
                         "ElementDataFile = LOCAL\n" +
                             samples);
    expect(3, isocast({"info", path}), {"nan.mha", "(1, 2, 3)", "nan"});
    expect_bad_field(path, {"nan.mha", "(1, 2, 3)", "nan"});
}

TEST_F(RefusedField, GridOfAFileThatHasNone) {
    const std::string path = input("a.mha", "NDims = 3\nDimSize = 1 1 1\nElementType = MET_UCHAR\n"
                                            "ElementDataFile = LOCAL\nx");
    expect_bad_field(path + ":density", {"a.mha", "'density'", ".vdb"});
    expect(3, isocast({"info", path + ":density"}), {"a.mha", "density"});
}

TEST_F(RefusedField, UnknownBuiltinName) {
    expect_bad_field("field:klein@16", {"'klein'", "torus", "gyroid"});
    expect_bad_field("field:torus@2", {"torus", "4"});
    expect_bad_field("field:torus@16x", {"field:torus@16x", "'16x'"});
}

TEST_F(RefusedOption, ResolutionOutOfRange) {
    expect(3, isocast({"convert", "mesh:knot", "-o", out("a.vdb"), "--resolution", "0"}),
           {"resolution 0"});
    expect(3, isocast({"convert", "mesh:knot", "-o", out("a.vdb"), "--resolution", "-5"}),
           {"resolution -5"});
    expect(3, isocast({"render", "mesh:knot", "-o", out("a.png"), "--resolution", "0"}),
           {"resolution 0"});
}

TEST_F(RefusedOption, MoreMemoryThanThereIs) {
    expect(4, isocast({"convert", "mesh:knot", "-o", out("a.vdb"), "--resolution", "1000000"}),
           {"memory", "voxel size"});
}

TEST_F(RefusedOption, VoxelSizeThatIsNotPositive) {
    expect(3, isocast({"convert", "mesh:knot", "-o", out("a.vdb"), "--voxel-size", "0"}),
           {"voxel size"});
    expect(2, isocast({"convert", "mesh:knot", "-o", out("a.vdb"), "--voxel-size", "nan"}),
           {"--voxel-size", "nan"});
}

TEST_F(RefusedOption, NumberThatDoesNotParseWhole) {
    for (const char* option :
         {"--voxel-size", "--resolution", "--band", "--band-world", "--threads"})
        expect(2, isocast({"convert", "mesh:knot", "-o", out("a.vdb"), option, "12abc"}),
               {option, "12abc"});
    for (const char* option : {"--iso", "--guarantee", "--repeat", "--resolution", "--size"})
        expect(2, isocast({"render", "mesh:knot", "-o", out("a.png"), option, "12abc"}),
               {option, "12abc"});
}

TEST_F(RefusedOption, PictureSize) {
    for (const char* size : {"nonsense", "64", "64x", "x64", "64x48x2", "0x48", "64x-48"})
        expect(2, isocast({"render", "field:torus@16", "-o", out("a.png"), "--size", size}),
               {"--size", size});
    // Float positions of rays in a picture hold 1/128 of a pixel up to there.
    expect(3, isocast({"render", "field:torus@16", "-o", out("a.png"), "--size", "1000000x16"}),
           {"1000000x16", "131072"});
}

TEST_F(RefusedOption, GuaranteeThatNoRayCanKeep) {
    for (const char* size : {"0", "-1", "0.00009", "1.1"})
        expect(2, isocast({"render", "field:torus@16", "-o", out("a.png"), "--guarantee", size}),
               {"--guarantee", "0.0001 and 1"});
}

TEST_F(RefusedOption, UnknownFilter) {
    expect(2, isocast({"render", "field:torus@16", "-o", out("a.png"), "--filter", "cubic"}),
           {"--filter", "cubic", "linear", "bspline", "interpolating", "exact", "catmull-rom"});
}

TEST_F(RefusedOption, StorageThatThereIsNot) {
    const auto refused = [&](const char* option, const char* value,
                             std::vector<std::string> words) {
        words.insert(words.begin(), {option, value});
        expect(2, isocast({"render", "field:torus@16", "-o", out("a.png"), option, value}), words);
    };
    refused("--storage", "float8", {"float32", "float16", "norm16"});
    refused("--fetch", "cells", {"rows", "samples", "linear", "auto"});
    refused("--derivative-filter", "cubic", {"linear", "bspline", "interpolating"});
    expect(3,
           isocast({"render", "field:torus@16", "-o", out("a.png"), "--fetch", "linear", "--filter",
                    "catmull-rom"}),
           {"linear fetches", "catmull-rom", "rows"});
    refused("--over-budget", "drop", {"stream", "coarsen"});
    expect(2,
           isocast({"render", "field:torus@16", "-o", out("a.png"), "--over-budget", "coarsen",
                    "--filter", "linear"}),
           {"--over-budget", "B-spline", "linear"});
    expect(4,
           isocast({"render", "field:torus@32", "-o", out("a.png"), "--over-budget", "coarsen",
                    "--texture-memory", "0.001"}),
           {"texture budget", "bricks need"});
    for (const char* mebibytes : {"0", "-1", "nan"}) refused("--texture-memory", mebibytes, {});
    for (const char* rate : {"0", "-1", "65"}) refused("--rate", rate, {"64"});
    refused("--rate-factor", "0", {});
    // A texture budget that holds no brick, or not all where all are needed.
    expect(4,
           isocast({"render", "field:torus@16", "-o", out("a.png"), "--texture-memory", "0.001"}),
           {"texture budget", "brick"});
    expect(4,
           isocast({"render", "field:torus@64", "-o", out("a.png"), "--texture-memory", "0.1",
                    "--rate", "1"}),
           {"rate", "all bricks"});
}

TEST_F(RefusedOption, UnknownOption) {
    for (const char* verb : {"convert", "render", "info", "sample"})
        expect(2, isocast({verb, "mesh:knot", "-o", out("a.vdb"), "--frobnicate"}),
               {"--frobnicate"});
    expect(2, isocast({"convert", "mesh:knot", "-o", out("a.vdb"), "--backend", "egl"}),
           {"--backend"});
}

TEST_F(RefusedOption, UnknownVerb) {
    expect(2, isocast({"frobnicate"}), {"frobnicate"});
    expect(2, isocast({}), {"convert", "render", "info", "sample"});
}

TEST_F(RefusedOption, UnknownValueListsTheKnownOnes) {
    expect(2, isocast({"convert", "mesh:knot", "-o", out("a.vdb"), "--sign", "guess"}),
           {"--sign", "'guess'", "auto, normal, winding"});
    for (const char* backend : {"vulkan", "window"})
        expect(2, isocast({"render", "field:torus", "-o", out("a.png"), "--backend", backend}),
               {"--backend", backend, "auto, egl, osmesa"});
    expect(2, isocast({"render", "field:torus", "-o", out("a.exr"), "--aov", "P,Q"}),
           {"--aov", "'Q'", "P, N"});
    expect(2, isocast({"render", "field:torus", "-o", out("a.png"), "--camera", "zoom=2"}),
           {"--camera", "'zoom'", "eye, target, direction, up, fov, height"});
}

TEST_F(RefusedOption, OptionsThatDoNotGoTogether) {
    expect(2,
           isocast({"convert", "mesh:knot", "-o", out("a.vdb"), "--voxel-size", "1", "--resolution",
                    "8"}),
           {"--voxel-size", "--resolution"});
    expect(
        2,
        isocast({"convert", "mesh:knot", "-o", out("a.vdb"), "--band", "3", "--band-world", "1"}),
        {"--band", "--band-world"});
    expect(2, isocast({"render", "field:torus", "-o", out("a.png"), "--aov", "P"}),
           {"--aov", "a.png", ".exr"});
    expect(2, isocast({"render", "field:torus", "-o", out("a.png"), "--resolution", "64"}),
           {"--resolution", "field:torus"});
}

TEST_F(RefusedOutput, WrongExtension) {
    expect(2, isocast({"convert", "mesh:knot", "-o", out("a.obj")}), {"a.obj", ".vdb"});
    expect(2, isocast({"render", "field:torus", "-o", out("a.jpg")}), {"a.jpg", ".png", ".exr"});
    expect(2, isocast({"sample", "mesh:knot", "-o", out("a.vdb")}), {"a.vdb", ".obj"});
    expect(2, isocast({"sample", "field:torus", "-o", out("a.obj")}), {"a.obj", ".vdb"});
}

TEST_F(RefusedOutput, FolderThatDoesNotExist) {
    expect(3, isocast({"convert", "mesh:knot", "-o", out("no/a.vdb")}),
           {"a.vdb", "does not exist"});
    expect(3, isocast({"render", "field:torus", "-o", out("no/a.png")}),
           {"a.png", "does not exist"});
    expect(3, isocast({"sample", "mesh:knot", "-o", out("no/a.obj")}), {"a.obj", "does not exist"});
}

TEST_F(RefusedOutput, IsLookedAtBeforeTheLongWork) {
    // Converting at this resolution would be refused for its memory, with another code.
    expect(3,
           isocast({"convert", "mesh:sphere6", "-o", out("no/a.vdb"), "--resolution", "1000000"}),
           {"does not exist"});
}

TEST_F(RefusedOutput, DiskThatIsFull) {
    // The shell's limit of the file size, in KiB, stands for a full disk.
    const auto limited = [&](const std::string& arguments) {
        return run("bash", {"-c", "ulimit -f 1; exec \"$0\" " + arguments, ISOCAST_PROGRAM},
                   {{"ASAN_OPTIONS", "detect_leaks=0"}});
    };
    const std::string picture = "render field:torus@16 --size 256x256 --backend osmesa -o ";
    expect(4, limited("convert mesh:knot --resolution 32 -o " + out("a.vdb")), {"a.vdb"});
    expect(4, limited(picture + out("a.png")), {"a.png"});
    expect(4, limited(picture + out("a.exr")), {"a.exr"});
    for (const char* name : {"a.obj", "a.ply", "a.stl", "a.off"})
        expect(4, limited("sample mesh:knot -o " + out(name)), {name});
}

TEST_F(RefusedOutput, ReportThatDoesNotArrive) {
    const Outcome outcome =
        run("bash", {"-c", "exec \"$0\" info mesh:knot >/dev/full", ISOCAST_PROGRAM});
    expect(1, outcome, {"report", "No space left"});
}

// A version below what we need, and no EGL driver at all: works on machines with a GPU, too.
const Environment no_gl{{"MESA_GL_VERSION_OVERRIDE", "2.1"},
                        {"__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent"}};

TEST_F(Refused, NoUsableGlSaysWhatWasTriedAndWhy) {
    expect(5, isocast({"render", "field:torus@16", "-o", out("a.png")}, no_gl),
           {"tried", "egl: ", "osmesa: "});
    expect(5, isocast({"render", "field:torus@16", "-o", out("a.png"), "--backend", "egl"}, no_gl),
           {"tried egl: "});
}

TEST_F(Refused, BadInputIsNamedEvenWithoutGl) {
    expect(3, isocast({"render", folder / "nowhere.obj", "-o", out("a.png")}, no_gl),
           {"nowhere.obj"});
    expect(3, isocast({"render", "mesh:teapot", "-o", out("a.png")}, no_gl), {"'teapot'"});
}

} // namespace
} // namespace isocast::test
