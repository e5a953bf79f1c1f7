// Damaged mesh files: whatever the bytes, a valid mesh or an InputError, soon.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/mesh_parsers.h"
#include "volume/errors.h"
#include "watched_allocation.h"

#include "../../volume/temporary_folder.h"

#include <gtest/gtest.h>

#include <bit>
#include <chrono>
#include <cstdlib>
#include <cstring>
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

template<class T>
void append(std::string& bytes, T value, std::endian order = std::endian::little) {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    if (order != std::endian::native) std::ranges::reverse(raw);
    bytes.append(raw.data(), raw.size());
}

/// Quadrilaterals with normals and colours, as other programs write them.
std::string ply_of_a_quadrilateral(std::endian order) {
    std::string bytes = std::string("ply\nformat binary_") +
                        (order == std::endian::little ? "little" : "big") +
                        "_endian 1.0\ncomment c\nobj_info i\nelement vertex 4\n"
                        "property float x\nproperty float y\nproperty float z\n"
                        "property uchar red\nproperty list uchar short tags\n"
                        "element face 2\nproperty uchar flags\n"
                        "property list uchar int vertex_indices\n"
                        "element edge 1\nproperty int vertex1\nproperty int vertex2\n"
                        "end_header\n";
    for (int v = 0; v < 4; ++v) {
        for (const int x : {v & 1, v >> 1, 0}) append(bytes, static_cast<float>(x), order);
        bytes += "\x7f\2";
        for (const short tag : {7, 8}) append(bytes, tag, order);
    }
    for (int f = 0; f < 2; ++f) {
        bytes += std::string("\0\4", 2);
        for (const int v : {0, 1, 3, 2}) append(bytes, v, order);
    }
    for (const int v : {0, 3}) append(bytes, v, order);
    return bytes;
}

std::string binary_stl(const Mesh& mesh) {
    std::string bytes(80, ' ');
    append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const std::array<int, 3>& triangle : mesh.triangles) {
        for (int k = 0; k < 3; ++k) append(bytes, 0.F);
        for (const int vertex : triangle)
            for (const double x : mesh.vertices_world[vertex]) append(bytes, static_cast<float>(x));
        append(bytes, std::uint16_t{0});
    }
    return bytes;
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
    all.push_back({parse_ply, ply_of_a_quadrilateral(std::endian::little)});
    all.push_back({parse_ply, ply_of_a_quadrilateral(std::endian::big)});
    all.push_back({parse_ply, "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\n"
                              "property float x\nproperty float y\nproperty float z\n"
                              "property list uchar int tags\nelement face 2\n"
                              "property list uchar int vertex_indices\nend_header\n"
                              "0 0 0 0\n1 0 0 1 5\n1 1 0 2 7 8\n0 1 0 0\n3 0 1 2\n3 0 2 3\n"});
    all.push_back({parse_stl, binary_stl(octahedron())});
    all.push_back({parse_obj, "mtllib m.mtl\no a\nv 0 0 0\nv 1 0 0 1\nv 0 1 0\nvt 0 0\nvn 0 0 1\n"
                              "g b\nusemtl c\ns 1\nf 1/1/1 \\\n -2//1 3/1\nl 1 2\n# end\n"});
    all.push_back({parse_off, "COFF # colours\n4 2 0\n0 0 0 255 0 0 255\n1 0 0 0 0 0 0\n"
                              "1 1 0 0 0 0 0\n0 1 0 0 0 0 0\n4 0 1 2 3 1 0 0\n3 0 1 2\n"});
    return all;
}

TEST(MeshMutation, WholeFilesAreMeshes) {
    for (const Seed& seed : seeds())
        EXPECT_GT(seed.parse(seed.bytes, "m").triangles.size(), 0u) << seed.bytes;
}

/// True if the bytes were taken for a mesh; every index of that is then valid.
bool is_taken(const Seed& seed, std::string_view bytes) {
    struct Watch {
        std::size_t size;
        std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
        ~Watch() {
            // A corner of a polygon has two bytes of text and becomes a triangle of twelve, in a
            // vector that doubles; 64 KiB: messages and buffers of the library.
            EXPECT_LT(largest_allocation(), 64 * size + (std::size_t{1} << 16));
            // Thousands of times what it takes: a loop that goes on, not a busy machine.
            EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
        }
    };
    largest_allocation() = 0;
    const Watch watch{bytes.size()};
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
        "-1",   "0",    "4294967295", "1e999",       "nan",  "9223372036854775807",
        "-0x7", "list", "\n",         "\r",          "\\",   "end_header\n",
        "#",    " ",    "/",          "solid",       "\xff", "element x 9999999999999\n",
        "f",    "v ",   "endsolid",   "1e-400",      "3 ",   "property list int int i\n",
        "uint", "OFF",  "binary",     "2147483648 ", "\t",   "1000000 "};
    const auto below = [&](std::size_t n) { return random() % std::max<std::size_t>(n, 1); };
    for (std::size_t edits = 1 + below(4); edits > 0; --edits) {
        const std::size_t at = below(bytes.size());
        switch (below(8)) {
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
        case 5: // a count or a number of four bytes, small, great or negative
            for (std::size_t k = 0; k < 4 && at + k < bytes.size(); ++k)
                bytes[at + k] = static_cast<char>(below(2) == 0 ? 0xff : below(4));
            break;
        case 6: { // a word instead of a number
            const std::size_t digit = bytes.find_first_of("0123456789", at);
            if (digit == std::string::npos) break;
            const std::size_t end = bytes.find_first_not_of("0123456789.", digit);
            bytes.replace(digit, end - digit, words[below(words.size())]);
            break;
        }
        default: { // a piece of another file
            const std::string& other = all[below(all.size())].bytes;
            bytes.insert(at, other.substr(below(other.size()), below(60)));
        }
        }
    }
    return bytes;
}

std::uint32_t from_environment(const char* name, std::uint32_t otherwise) {
    const char* const text = std::getenv(name);
    return text == nullptr ? otherwise : static_cast<std::uint32_t>(std::stoul(text));
}

// Each file follows from its number alone, so that any range can be run apart.
TEST(MeshMutation, DamagedFilesAreMeshesOrInputErrors) {
    const std::uint32_t first = from_environment("ISOCAST_MUTATION_FIRST", 0);
    const std::uint32_t count = from_environment("ISOCAST_MUTATION_COUNT", 20000);
    const std::vector<Seed> all = seeds();
    std::vector<std::uint32_t> tried(all.size());
    std::vector<std::uint32_t> taken(all.size());
    for (std::uint32_t number = first; number < first + count; ++number) {
        SCOPED_TRACE(number);
        std::mt19937 random(number);
        const std::size_t which = random() % all.size();
        ++tried[which];
        taken[which] += is_taken(all[which], mutated(all[which].bytes, all, random)) ? 1 : 0;
        if (HasFailure()) return;
    }
    // Of no kind all are refused or all taken: the mutations reach the parsers' insides.
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_GT(taken[i], tried[i] / 100) << all[i].bytes;
        EXPECT_LT(taken[i], tried[i] * 9 / 10) << all[i].bytes;
    }
}

// Coordinates of any size, in any order: what the parsers take is examined and converted, or
// refused.
TEST(MeshMutation, WhatIsTakenConvertsOrIsRefused) {
    const std::vector<Seed> all = seeds();
    const std::uint32_t first = from_environment("ISOCAST_MUTATION_FIRST", 0);
    const std::uint32_t count = from_environment("ISOCAST_MUTATION_COUNT", 3000);
    std::uint32_t converted = 0;
    for (std::uint32_t number = first; number < first + count; ++number) {
        SCOPED_TRACE(number);
        std::mt19937 random(number);
        const Seed& seed = all[random() % all.size()];
        try {
            const CheckedMesh mesh = check(seed.parse(mutated(seed.bytes, all, random), "m"));
            const SparseField field =
                convert(mesh,
                        {.voxel_size_world = voxel_size_for_resolution(bounding_box(mesh.mesh), 8)})
                    .field;
            EXPECT_GT(field.active_voxel_count(), 0);
            for (const FieldBlock& block : field.blocks())
                for (const float value : block.values) ASSERT_TRUE(std::isfinite(value));
            ++converted;
        } catch (const InputError&) {
        } catch (const ResourceError&) {
        }
        if (HasFailure()) return;
    }
    EXPECT_GT(converted, count / 10);
}

} // namespace
} // namespace isocast::test
