// Damaged mesh files: whatever the bytes, a valid mesh or an InputError, soon.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh_files.h"
#include "distance_transform/mesh_parsers.h"
#include "fields.h"
#include "volume/errors.h"

#include "../volume/temporary_folder.h"

#include <fstream>
#include <iterator>
#include <random>

namespace isocast::test {
namespace {

using Parser = Mesh (*)(std::string_view bytes, std::string_view name);

struct Seed {
    Parser parse;
    std::string bytes;
};

Mesh octahedron() {
    Mesh mesh;
    mesh.vertices_world = {Vec3d(1, 0, 0),  Vec3d(-1, 0, 0), Vec3d(0, 1, 0),
                           Vec3d(0, -1, 0), Vec3d(0, 0, 1),  Vec3d(0, 0, -1)};
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                      {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    return mesh;
}

/// One small whole file of each format and variant.
std::vector<Seed> seeds() {
    const TemporaryFolder folder;
    std::vector<Seed> all;
    const auto add_written = [&](Parser parse, const std::string& name) {
        write_mesh(octahedron(), folder / name);
        std::ifstream file(folder / name, std::ios::binary);
        all.push_back({parse, std::string(std::istreambuf_iterator<char>(file), {})});
    };
    add_written(parse_obj, "a.obj");
    add_written(parse_ply, "a.ply");
    add_written(parse_stl, "a.stl");
    add_written(parse_off, "a.off");
    std::string big_endian = all[1].bytes;
    big_endian.replace(big_endian.find("little"), 6, "big");
    all.push_back({parse_ply, big_endian}); // its counts and indices are all out of range
    all.push_back({parse_ply, "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\n"
                              "property float x\nproperty float y\nproperty float z\n"
                              "property list uchar int tags\nelement face 2\n"
                              "property list uchar int vertex_indices\nend_header\n"
                              "0 0 0 0\n1 0 0 1 5\n1 1 0 2 7 8\n0 1 0 0\n3 0 1 2\n3 0 2 3\n"});
    std::string stl(80, ' ');
    stl += std::string("\x02\0\0\0", 4) + std::string(100, '\0');
    all.push_back({parse_stl, stl});
    all.push_back({parse_obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 \\\n -2//1 3/1\n# end\n"});
    return all;
}

/// True if the bytes were taken for a mesh; every index of that is then valid.
bool is_taken(const Seed& seed, std::string_view bytes) {
    try {
        const Mesh mesh = seed.parse(bytes, "m");
        const int count = static_cast<int>(mesh.vertices_world.size());
        for (const std::array<int, 3>& triangle : mesh.triangles)
            for (const int vertex : triangle) EXPECT_TRUE(vertex >= 0 && vertex < count);
        for (const Vec3d& p : mesh.vertices_world) EXPECT_TRUE(p.allFinite());
        return true;
    } catch (const InputError& error) {
        EXPECT_TRUE(std::string_view(error.what()).starts_with("m: ")) << error.what();
        EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos);
        return false;
    }
}

TEST(MeshMutation, EveryPrefixIsAMeshOrAnInputError) {
    for (const Seed& seed : seeds()) {
        for (std::size_t length = 0; length < seed.bytes.size(); ++length)
            // A copy of that very size, so that a sanitizer sees any read past its end.
            is_taken(seed, std::string(seed.bytes.data(), length));
    }
}

std::string mutated(std::string bytes, const std::vector<Seed>& all, std::mt19937& random) {
    static constexpr std::array words = {
        "-1",   "0",    "4294967295", "1e999", "nan",
        "-0x7", "list", "\n",         "\r",    "\\",
        "#",    " ",    "/",          "solid", "element x 9999999999999\n"};
    const auto below = [&](std::size_t n) { return random() % std::max<std::size_t>(n, 1); };
    for (std::size_t edits = 1 + below(4); edits > 0; --edits) {
        const std::size_t at = below(bytes.size());
        switch (below(6)) {
        case 0: // one bit
            if (!bytes.empty()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
            break;
        case 1: // one byte
            if (!bytes.empty()) bytes[at] = static_cast<char>(random());
            break;
        case 2:
            bytes.resize(at);
            break;
        case 3:
            bytes.insert(at, words[below(words.size())]);
            break;
        case 4:
            bytes.erase(at, below(16));
            break;
        default: { // a piece of another file
            const std::string& other = all[below(all.size())].bytes;
            bytes.insert(at, other.substr(below(other.size()), below(40)));
        }
        }
    }
    return bytes;
}

TEST(MeshMutation, DamagedFilesAreMeshesOrInputErrors) {
    const std::vector<Seed> all = seeds();
    std::mt19937 random(2026);
    int taken = 0;
    constexpr int count = 40000;
    for (int i = 0; i < count; ++i) {
        const Seed& seed = all[random() % all.size()];
        taken += is_taken(seed, mutated(seed.bytes, all, random)) ? 1 : 0;
    }
    // Neither all refused nor all taken: the mutations reach the parsers' insides.
    EXPECT_GT(taken, count / 100);
    EXPECT_LT(taken, count * 9 / 10);
}

} // namespace
} // namespace isocast::test
