// Reading and writing meshes: every format's variants, and errors that name their cause.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh_files.h"

#include "distance_transform/mesh_parsers.h"
#include "distance_transform/sample_meshes.h"
#include "fields.h"
#include "volume/errors.h"

#include "../volume/temporary_folder.h"

#include <sys/resource.h>

#include <bit>
#include <csignal>
#include <fstream>

namespace isocast::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Parser = Mesh (*)(std::string_view bytes, std::string_view name);

std::string error_of(Parser parse, std::string_view bytes) {
    return message_of<InputError>([&] { parse(bytes, "m"); });
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), std::ssize(bytes));
}

void expect_square(const Mesh& mesh) {
    const std::vector<Vec3d> corners = {Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(1, 1, 0),
                                        Vec3d(0, 1, 0.25)};
    EXPECT_EQ(mesh.vertices_world, corners);
    const std::vector<std::array<int, 3>> triangles = {{0, 1, 2}, {0, 2, 3}};
    EXPECT_EQ(mesh.triangles, triangles);
}

/// Appends a value's bytes, reversed for big-endian files.
template<class T>
void append(std::string& bytes, T value, bool reverse = false) {
    auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (reverse) std::reverse(raw.begin(), raw.end());
    bytes.append(raw.data(), raw.size());
}

TEST(MeshFiles, ObjVariantsGiveTheSameMesh) {
    expect_square(parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.25\nf 1 2 3 4\n", "m"));
    expect_square(parse_obj("# c\r\nmtllib a.mtl\r\nv 0 0 0 1.0\r\nv\t+1 0 0\r\nv 1 1 0\r\n"
                            "v 0 1e0 25e-2\r\nvn 0 0 1\r\nvt 0 0\r\ng x\r\nf 1/1/1 2/1/1 3//1 4/1",
                            "m"));
    expect_square(
        parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 \\\n0\nv 0 1 .25 # c\nf -4 -3 \\\r\n -2\\\n -1", "m"));
    expect_square(parse_obj("f 1 2 3\nf 1 3 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.25\n", "m"));
    expect_square(parse_obj("v 0 0 0\rv 1 0 0\rv 1 1 0\rv 0 1 0.25\rf 1 2 3 4\r", "m"));
}

TEST(MeshFiles, ObjErrorsNameTheLine) {
    EXPECT_EQ(error_of(parse_obj, "v 0 0 0\nv 1 nan 0\n"), "m: line 2: y is not finite: 'nan'");
    EXPECT_EQ(error_of(parse_obj, "v 0 0 1e999\n"), "m: line 1: z does not fit a double: '1e999'");
    EXPECT_EQ(error_of(parse_obj, "v 0 0\n"), "m: line 1: z is missing");
    EXPECT_EQ(error_of(parse_obj, "v 0 0 x7\n"), "m: line 1: z is not a number: 'x7'");
    EXPECT_EQ(error_of(parse_obj, "v 0 0 0\nf 1 1 9\n"),
              "m: line 2: vertex index 9 of face 1 is out of range: there are 1 vertices");
    EXPECT_EQ(error_of(parse_obj, "v 0 0 0\n\nf 1 0 1\n"),
              "m: line 3: vertex index 0 is out of range: there are 1 vertices so far");
    EXPECT_EQ(error_of(parse_obj, "v 0 0 0\nf 1 -2 1\n"),
              "m: line 2: vertex index -2 is out of range: there are 1 vertices so far");
    EXPECT_EQ(error_of(parse_obj, "v 0 0 0\nf 1 1\n"), "m: line 2: face 1 has 2 corners");
    EXPECT_THAT(error_of(parse_obj, "f 1 2 99999999999999999999\n"), HasSubstr("not an integer"));
    EXPECT_THAT(error_of(parse_obj, "f 1 2 4294967296\n"), HasSubstr("too large"));
}

TEST(MeshFiles, OffVariantsGiveTheSameMesh) {
    expect_square(parse_off("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0.25\n4 0 1 2 3\n", "m"));
    expect_square(parse_off("OFF 4 1 4 # counts\r\n\r\n# c\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n"
                            "0 1 0.25\r\n4 0 1 2 3 255 0 0",
                            "m"));
    expect_square(parse_off("COFF\n4 1 0\n0 0 0 255 0 0 0\n1 0 0 255 0 0 0\n1 1 0 1 1 1 1\n"
                            "0 1 0.25 1 1 1 1\n4 0 1 2 3\n",
                            "m"));
}

TEST(MeshFiles, OffErrorsNameTheLine) {
    EXPECT_EQ(error_of(parse_off, "OFF\n4 1 0\n0 0 0\n1 0 0\n"),
              "m: truncated: it holds 2 of 4 vertices");
    EXPECT_EQ(error_of(parse_off, "OFF\n1 2 0\n0 0 0\n3 0 0 0\n"),
              "m: truncated: it holds 1 of 2 faces");
    EXPECT_EQ(error_of(parse_off, "OFF\n1 1 0\n0 0 0\n3 0 1 0\n"),
              "m: line 4: vertex index 1 of face 0 is out of range: there are 1 vertices");
    EXPECT_EQ(error_of(parse_off, "OFF\n1 1 0\n0 inf 0\n3 0 0 0\n"),
              "m: line 3: y is not finite: 'inf'");
    EXPECT_EQ(error_of(parse_off, "OFF BINARY\n"), "m: line 1: binary OFF is not supported");
    EXPECT_THAT(error_of(parse_off, "OFF\n-1 1 0\n"), HasSubstr("negative"));
    EXPECT_THAT(error_of(parse_off, "PLY\n"), HasSubstr("'PLY'"));
    EXPECT_THAT(error_of(parse_off, "OFF\n9000000000000000000 1 0\n0 0 0\n"),
                HasSubstr("1 of 9000000000000000000 vertices"));
}

TEST(MeshFiles, TextPlyWithExtraElementsAndProperties) {
    expect_square(parse_ply("ply\r\nformat ascii 1.0\r\ncomment by hand\r\nobj_info x\r\n"
                            "element material 1\r\nproperty list uchar float shades\r\n"
                            "element vertex 4\r\nproperty uchar red\r\nproperty float z\r\n"
                            "property double x\r\nproperty list int short tags\r\n"
                            "property float32 y\r\nelement edge 2\r\nelement face 1\r\n"
                            "property float quality\r\nproperty list uint8 int32 vertex_index\r\n"
                            "end_header\r\n2 0.5 nan\r\n9 0 0 0 0\r\n9 0 1 2 7 8 0\r\n"
                            "9 0 1 0 1\r\n9 0.25 0 1 5 1\r\n0.5 4 0 1 2 3\r\n",
                            "m"));
}

std::string binary_ply(bool big_endian) {
    std::string bytes = "ply\nformat ";
    bytes += big_endian ? "binary_big_endian" : "binary_little_endian";
    bytes += " 1.0\nelement face 1\nproperty uint8 flags\n"
             "property list ushort uint vertex_indices\nproperty list uchar float uv\n"
             "element vertex 4\nproperty short y\nproperty list uint8 double weights\n"
             "property float x\nproperty double z\nend_header\n";
    append(bytes, std::uint8_t{1}, big_endian);
    append(bytes, std::uint16_t{4}, big_endian);
    for (std::uint32_t i = 0; i < 4; ++i) append(bytes, i, big_endian);
    append(bytes, std::uint8_t{1}, big_endian);
    append(bytes, 0.5f, big_endian);
    const std::array<Vec3d, 4> corners = {Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(1, 1, 0),
                                          Vec3d(0, 1, 0.25)};
    for (const Vec3d& p : corners) {
        append(bytes, static_cast<std::int16_t>(p.y()), big_endian);
        append(bytes, std::uint8_t{2}, big_endian);
        append(bytes, 0.1, big_endian);
        append(bytes, 0.2, big_endian);
        append(bytes, static_cast<float>(p.x()), big_endian);
        append(bytes, p.z(), big_endian);
    }
    return bytes;
}

TEST(MeshFiles, BinaryPlyOfBothByteOrdersWithFacesFirst) {
    expect_square(parse_ply(binary_ply(false), "m"));
    expect_square(parse_ply(binary_ply(true), "m"));
}

std::string text_ply(std::string_view vertex_count, std::string_view body) {
    return "ply\nformat ascii 1.0\nelement vertex " + std::string(vertex_count) +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
           "property list uchar int vertex_indices\nend_header\n" +
           std::string(body);
}

TEST(MeshFiles, PlyErrorsNameTheElement) {
    EXPECT_EQ(error_of(parse_ply, text_ply("3", "0 0 0\n1 0 0\n1 1\n")),
              "m: truncated: it holds 2 of 3 elements 'vertex'");
    EXPECT_EQ(error_of(parse_ply, text_ply("1", "0 0 0\n3 0 0")),
              "m: truncated: it holds 0 of 1 elements 'face'");
    EXPECT_EQ(error_of(parse_ply, text_ply("2", "0 0 0\n0 -inf 0\n3 0 0 1\n")),
              "m: vertex 1: y is not finite");
    EXPECT_EQ(error_of(parse_ply, text_ply("1", "0 0 0\n3 0 1 0\n")),
              "m: face 0: vertex index 1 is out of range: there are 1 vertices");
    EXPECT_EQ(error_of(parse_ply, text_ply("1", "0 0 0\n3 0 -1 0\n")),
              "m: face 0: vertex index -1 is out of range: there are 1 vertices");
    EXPECT_EQ(error_of(parse_ply, text_ply("1", "0 0 0\n2 0 0\n")), "m: face 0 has 2 corners");
    EXPECT_EQ(error_of(parse_ply, text_ply("1", "0 0 0\n-3 0 0\n")),
              "m: face 0: a list has -3 entries");
    EXPECT_EQ(error_of(parse_ply, text_ply("1", "0 x 0\n3 0 0 0\n")),
              "m: line 10: a value is not a number: 'x'");
    EXPECT_THAT(error_of(parse_ply, text_ply("5000000000", "0 0 0\n")), HasSubstr("too many"));
    EXPECT_EQ(error_of(parse_ply, text_ply("2000000000", "0 0 0\n")),
              "m: truncated: it holds 1 of 2000000000 elements 'vertex'");
    const std::string binary = binary_ply(false);
    EXPECT_EQ(error_of(parse_ply, std::string_view(binary).substr(0, binary.size() - 1)),
              "m: truncated: it holds 3 of 4 elements 'vertex'");
}

TEST(MeshFiles, PlyHeaderErrorsSayWhatIsWrong) {
    EXPECT_THAT(error_of(parse_ply, "plyx\n"), HasSubstr("does not begin with 'ply'"));
    EXPECT_THAT(error_of(parse_ply, "ply\nformat ascii 1.0\n"), HasSubstr("no 'end_header'"));
    EXPECT_THAT(error_of(parse_ply, "ply\nformat utf8 1.0\n"),
                AllOf(HasSubstr("line 2"), HasSubstr("binary_big_endian")));
    EXPECT_THAT(error_of(parse_ply, "ply\nelement vertex 3\nproperty half x\n"),
                HasSubstr("unknown property type 'half'"));
    EXPECT_THAT(error_of(parse_ply, "ply\nproperty float x\n"),
                HasSubstr("before the first element"));
    EXPECT_THAT(error_of(parse_ply, "ply\nwhat\n"), HasSubstr("unexpected 'what'"));
    EXPECT_THAT(error_of(parse_ply, "ply\nelement vertex -1\n"), HasSubstr("negative"));
    EXPECT_THAT(error_of(parse_ply, "ply\nend_header\n"), HasSubstr("no 'format'"));
    EXPECT_THAT(error_of(parse_ply, "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                    "element tristrips 1\nend_header\n"),
                HasSubstr("no element 'face' (has: vertex, tristrips)"));
    EXPECT_THAT(error_of(parse_ply, "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                    "property float y\nelement face 1\n"
                                    "property list uchar int vertex_indices\nend_header\n"),
                HasSubstr("element 'vertex' has no number 'z' (has: x, y)"));
}

std::string binary_stl(std::string_view comment, std::uint32_t announced, int facets) {
    std::string bytes(comment);
    bytes.resize(80, ' ');
    append(bytes, announced);
    for (int i = 0; i < facets; ++i) {
        for (const float x : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, float(i)})
            append(bytes, x);
        append(bytes, std::uint16_t{0});
    }
    return bytes;
}

TEST(MeshFiles, BinaryStlIsKnownByItsSizeNotByTheWordSolid) {
    const Mesh mesh = parse_stl(binary_stl("solid exported by a liar", 2, 2), "m");
    EXPECT_EQ(mesh.vertices_world.size(), 6u);
    EXPECT_EQ(mesh.triangles.size(), 2u);
    EXPECT_EQ(mesh.vertices_world[5], Vec3d(0, 1, 1));
}

TEST(MeshFiles, TextStlOfSeveralSolids) {
    const std::string facet = "facet normal nan 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                              "vertex 0 1e-3 0\nendloop\nendfacet\n";
    const Mesh mesh =
        parse_stl("solid one two\r\n" + facet + "endsolid one\nSOLID\n" + facet + "ENDSOLID", "m");
    EXPECT_EQ(mesh.triangles.size(), 2u);
    EXPECT_EQ(mesh.vertices_world[2], Vec3d(0, 1e-3, 0));
}

TEST(MeshFiles, StlErrorsSayWhatIsWrong) {
    EXPECT_THAT(error_of(parse_stl, binary_stl("", 7, 3)),
                AllOf(HasSubstr("7 triangles"), HasSubstr("3 whole triangles")));
    EXPECT_THAT(error_of(parse_stl, binary_stl("", 0xffffffff, 0)), HasSubstr("4294967295"));
    EXPECT_THAT(error_of(parse_stl, "facet"), HasSubstr("too short"));
    EXPECT_THAT(error_of(parse_stl, "solid\nfacet\nouter loop\nvertex 0 0 0\n"),
                HasSubstr("truncated: it ends before 'endsolid'"));
    EXPECT_EQ(error_of(parse_stl, "solid\nvertex 0 0 nan\n"), "m: line 2: z is not finite: 'nan'");
    EXPECT_EQ(error_of(parse_stl, "solid\nvertex 0 0 0\nendloop\n"),
              "m: line 3: a facet has 1 vertices");
    EXPECT_EQ(error_of(parse_stl, "solid\nwhat 0\n"), "m: line 2: unexpected 'what' in a text STL");
    std::string nan = binary_stl("", 1, 1);
    nan.replace(84 + 12, 4, "\xff\xff\xff\xff");
    EXPECT_EQ(error_of(parse_stl, nan), "m: triangle 0: a coordinate is not finite");
}

TEST(MeshFiles, WhatIsWrittenIsReadBackExactly) {
    const TemporaryFolder folder;
    Mesh mesh = sample_mesh("knot");
    mesh.vertices_world[0] = Vec3d(0.1, -1e-300, 1e300 / 3);
    for (const std::string name : {"a.obj", "a.ply", "a.off", "A.OBJ"}) {
        write_mesh(mesh, folder / name);
        const Mesh read = read_mesh(folder / name);
        EXPECT_EQ(read.vertices_world, mesh.vertices_world) << name;
        EXPECT_EQ(read.triangles, mesh.triangles) << name;
    }
    write_mesh(mesh, folder / "a.stl");
    const Mesh soup = read_mesh(folder / "a.stl");
    ASSERT_EQ(soup.triangles.size(), mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            ASSERT_EQ(soup.vertices_world[soup.triangles[t][k]],
                      mesh.vertices_world[mesh.triangles[t][k]]);
}

TEST(MeshFiles, FilesThatCannotBeReadAreNamed) {
    const TemporaryFolder folder;
    const auto message = [&](const std::string& name) {
        return message_of<InputError>([&] { read_mesh(folder / name); });
    };
    EXPECT_THAT(message("no.obj"), AllOf(HasSubstr("no.obj: cannot open: No such file")));
    EXPECT_THAT(message("a.gltf"),
                AllOf(HasSubstr("'.gltf'"), HasSubstr(".obj, .ply, .stl, .off")));
    EXPECT_THAT(message("bare"), HasSubstr("known: .obj"));
    std::filesystem::create_directory(folder / "d.obj");
    EXPECT_THAT(message("d.obj"), HasSubstr("is a directory"));
    write_file(folder / "empty.stl", "");
    EXPECT_THAT(message("empty.stl"), HasSubstr("the file is empty"));
    write_file(folder / "points.obj", "v 0 0 0\nv 1 0 0\n");
    EXPECT_THAT(message("points.obj"), HasSubstr("points.obj: no triangles (2 vertices)"));
}

TEST(MeshFiles, ExtensionsAreKnown) {
    EXPECT_TRUE(is_mesh_file("a.obj") && is_mesh_file("b/c.PLY") && is_mesh_file("x.Stl"));
    EXPECT_FALSE(is_mesh_file("a.vdb") || is_mesh_file("obj") || is_mesh_file(""));
    EXPECT_EQ(mesh_file_extensions(), ".obj, .ply, .stl, .off");
}

TEST(MeshFiles, FailedWriteLeavesNothingBehind) {
    const TemporaryFolder folder;
    const Mesh mesh = sample_mesh("torus");
    // A limit on the size of files fails as a full disk does; the signal would end the program.
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{1000, before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    const std::string message =
        message_of<ResourceError>([&] { write_mesh(mesh, folder / "a.obj"); });
    ::setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_THAT(message, AllOf(HasSubstr("a.obj"), HasSubstr("cannot write")));
    EXPECT_EQ(folder.entry_count(), 0);
    EXPECT_THROW(write_mesh(mesh, folder / "a.xyz"), InputError);
    EXPECT_THROW(write_mesh(mesh, folder / "no" / "a.obj"), InputError);
    EXPECT_EQ(folder.entry_count(), 0);
}

} // namespace
} // namespace isocast::test
