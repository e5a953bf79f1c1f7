// Tests of octree files.
// SPDX-License-Identifier: MPL-2.0
#include "volume/octree_file.h"

#include "octree_files.h"

namespace isocast {
namespace {

using test::bytes_of_file;
using test::message_of;
using test::Random;
using test::TemporaryFolder;
using test::write_bytes;

const std::map<std::string, std::string> provenance = {
    {"source", "a mesh = b.ply"}, {"creator", "isocast"}, {"", ""}};

std::string error_of(const std::filesystem::path& path) {
    return message_of<InputError>([&] { read_octree(path); });
}

TEST(OctreeFile, HoldsAllOfATree) {
    Random random(1);
    const TemporaryFolder folder;
    for (const int depth : {0, 1, 6, greatest_octree_depth})
        for (const OctreeFilter filter : {OctreeFilter::Linear, OctreeFilter::Cubic}) {
            const HashedOctree tree = test::random_octree(random, depth, filter, 200);
            write_octree(tree, test::turned_space(), provenance, folder / "a.hoct");
            const OctreeFile file = read_octree(folder / "a.hoct");
            EXPECT_EQ(file.provenance, provenance);
            EXPECT_EQ(file.space.world_from_index.matrix(),
                      test::turned_space().world_from_index.matrix());
            EXPECT_EQ(file.tree.depth(), depth);
            ASSERT_EQ(file.tree.filter(), filter);
            ASSERT_EQ(file.tree.cell_count(), tree.cell_count());
            tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
                ASSERT_TRUE(file.tree.find(cell));
                ASSERT_EQ(file.tree.is_divided(cell), !is_leaf);
            });
            HashedOctree::NodeNumber next = 0;
            tree.visit_nodes([&](const Index3& position, HashedOctree::NodeNumber node) {
                ASSERT_EQ(file.tree.find_node(position), next);
                ASSERT_TRUE(std::ranges::equal(file.tree.data_of(next), tree.data_of(node)));
                ASSERT_EQ(file.tree.is_constrained(next), tree.is_constrained(node));
                ++next;
            });
            EXPECT_EQ(next, file.tree.node_count());
        }
    EXPECT_EQ(folder.entry_count(), 1);
}

/// The same bytes on any machine, as docs/octree.md has them.
TEST(OctreeFile, OfOneDividedCellIsTheseBytes) {
    const TemporaryFolder folder;
    float next = 0;
    const auto count_up = [&](const Index3&, std::span<float> out) { out[0] = next++; };
    HashedOctree tree(1, OctreeFilter::Linear, count_up);
    tree.divide(tree.root(), count_up);
    tree.set_constrained(9, true);
    write_octree(tree, GridSpace::uniform(2, {1, 0, 0}), {{"k", "v"}}, folder / "a.hoct");
    std::string expected = "isoHOCT\n";
    const auto add = [&](auto value) {
        expected.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    auto end_section = [&, begin = std::size_t{0}]() mutable {
        add(static_cast<std::uint32_t>(
            ::crc32(0, reinterpret_cast<const Bytef*>(expected.data() + begin),
                    static_cast<uInt>(expected.size() - begin))));
        begin = expected.size();
    };
    add(std::uint32_t{1});
    for (const int byte : {1, 1, 0, 0}) add(static_cast<char>(byte));
    for (const double x : {2, 0, 0, 1, 0, 2, 0, 0, 0, 0, 2, 0}) add(x);
    for (const std::uint64_t size : {6, 1, 27}) add(size);
    end_section();
    expected += "k = v\n";
    end_section();
    add('\0');
    end_section();
    for (int i = 0; i < 27; ++i) add(static_cast<float>(i));
    end_section();
    for (const int byte : {0, 2, 0, 0}) add(static_cast<char>(byte));
    end_section();
    EXPECT_EQ(bytes_of_file(folder / "a.hoct"), expected);
}

TEST(OctreeFileErrors, CutShortAtEveryByteOrLongerIsRefused) {
    Random random(2);
    const TemporaryFolder folder;
    write_octree(test::random_octree(random, 3, OctreeFilter::Cubic, 4), {}, provenance,
                 folder / "a.hoct");
    const std::string whole = bytes_of_file(folder / "a.hoct");
    for (std::size_t size = 0; size < whole.size(); ++size) {
        write_bytes(folder / "b.hoct", whole.substr(0, size));
        ASSERT_NE(error_of(folder / "b.hoct"), "") << size;
    }
    write_bytes(folder / "b.hoct", whole + '\0');
    EXPECT_NE(error_of(folder / "b.hoct"), "");
}

TEST(OctreeFileErrors, WithADamagedByteAnywhereIsRefused) {
    Random random(3);
    const TemporaryFolder folder;
    write_octree(test::random_octree(random, 3, OctreeFilter::Linear, 6), {}, provenance,
                 folder / "a.hoct");
    const std::string whole = bytes_of_file(folder / "a.hoct");
    for (std::size_t i = 0; i < whole.size(); ++i)
        for (const int change :
             {1 << test::random_int(random, 0, 7), test::random_int(random, 1, 255)}) {
            std::string bytes = whole;
            bytes[i] = static_cast<char>(bytes[i] ^ change);
            write_bytes(folder / "b.hoct", bytes);
            ASSERT_NE(error_of(folder / "b.hoct"), "") << i;
        }
}

TEST(OctreeFileErrors, DamagedWithTheRightChecksumsIsATreeOrRefused) {
    const int read = test::read_damaged_octrees(4, 3000);
    EXPECT_GT(read, 300); // both happen
    EXPECT_LT(read, 2700);
}

TEST(OctreeFileErrors, NameFileAndCause) {
    const TemporaryFolder folder;
    const auto path = folder / "a.hoct";
    const std::string start = "cannot read " + path.string() + ": ";
    write_bytes(path, "ply\nformat ascii 1.0\n");
    EXPECT_EQ(error_of(path), start + "it is no octree file");
    const HashedOctree tree(0, OctreeFilter::Linear,
                            [](const Index3&, std::span<float> out) { out[0] = 1; });
    write_octree(tree, {}, {}, path);
    std::string bytes = bytes_of_file(path);
    write_bytes(path, bytes.substr(0, 100));
    EXPECT_EQ(error_of(path), start + "it ends within its header");
    bytes[50] ^= 1;
    write_bytes(path, bytes);
    EXPECT_EQ(error_of(path), start + "its header is damaged: the checksum differs");
    const auto write = [&](const std::string& key, const std::string& value) {
        return message_of<InputError>([&] {
            write_octree(tree, {}, {{key, value}}, folder / "b.hoct");
        });
    };
    EXPECT_EQ(write("a = b", "c"),
              "cannot write " + (folder / "b.hoct").string() + ": 'a = b' is no key of one line");
    EXPECT_NE(write("a", "b\nc"), "");
    EXPECT_EQ(folder.entry_count(), 1);
}

} // namespace
} // namespace isocast
