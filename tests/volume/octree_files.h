// Small octree files, whole and damaged.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "octree_oracle.h"
#include "temporary_folder.h"
#include "volume/octree_file.h"

#include <zlib.h>

#include <cstring>
#include <fstream>

namespace isocast::test {

/// A tree after divisions, merges and constraints, so that its numbers have gaps.
inline HashedOctree random_octree(Random& random, int depth, OctreeFilter filter, int changes) {
    const HashedOctree::NodeSampler sampler = [&](const Index3&, std::span<float> out) {
        for (float& value : out) value = static_cast<float>(random_real(random, -1, 1));
    };
    HashedOctree tree(depth, filter, sampler);
    for (int i = 0; i < changes; ++i) {
        const Vec3d p = random_finest(random, depth).cast<double>();
        if (tree.leaf_at(p).level > 0) tree.divide(tree.leaf_at(p), sampler);
        if (i == changes / 2) tree.constrain_hanging_nodes(sampler);
        const OctreeCell leaf = tree.leaf_at(random_finest(random, depth).cast<double>());
        bool can_merge = leaf.level < depth && i % 3 == 0;
        for (int j = 0; can_merge && j < 8; ++j)
            can_merge = !tree.is_divided(child_of(parent_of(leaf), j));
        if (can_merge) tree.merge(parent_of(leaf));
    }
    return tree;
}

inline std::string bytes_of_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}
/// A new file: some systems write one that replaces another to the disk at once.
inline void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
    std::filesystem::remove(path);
    std::ofstream(path, std::ios::binary) << bytes;
}

/// Where the file's sections begin and end, by what docs/octree.md says of its first.
inline std::vector<std::pair<std::size_t, std::size_t>> octree_sections(const std::string& bytes) {
    std::array<std::uint64_t, 3> counts; // bytes of text, divided cells, nodes
    std::memcpy(counts.data(), bytes.data() + 112, sizeof counts);
    std::vector<std::pair<std::size_t, std::size_t>> sections;
    std::size_t begin = 0;
    for (const std::uint64_t size :
         {std::uint64_t{136}, counts[0], counts[1],
          counts[2] * 4 * static_cast<unsigned char>(bytes[13]), (counts[2] + 7) / 8}) {
        sections.emplace_back(begin, begin + size);
        begin += size + 4;
    }
    return sections;
}

/// Damages up to four bytes of random sections and puts the checksums right again: what is read
/// must be a tree, and the rest refused.
/// returns  how many were read
inline int read_damaged_octrees(std::uint32_t seed, int count) {
    Random random(seed);
    const TemporaryFolder folder;
    int read = 0;
    std::string whole;
    std::vector<std::pair<std::size_t, std::size_t>> sections;
    for (int i = 0; i < count && !::testing::Test::HasFailure(); ++i) {
        if (i % 100 == 0) {
            const auto filter =
                random_int(random, 0, 1) ? OctreeFilter::Cubic : OctreeFilter::Linear;
            const HashedOctree tree = random_octree(random, random_int(random, 0, 4), filter, 6);
            std::filesystem::remove(folder / "a.hoct");
            write_octree(tree, GridSpace::uniform(0.5), {{"a", "b"}, {"c", "d"}},
                         folder / "a.hoct");
            whole = bytes_of_file(folder / "a.hoct");
            sections = octree_sections(whole);
        }
        std::string bytes = whole;
        for (int j = random_int(random, 1, 4); j > 0; --j) {
            const auto [begin, end] = sections[static_cast<std::size_t>(random_int(random, 0, 4))];
            if (begin == end) continue;
            const int at = random_int(random, static_cast<int>(begin), static_cast<int>(end) - 1);
            char& byte = bytes[static_cast<std::size_t>(at)];
            byte = static_cast<char>(random_int(random, 0, 1) ? byte ^ 1 << random_int(random, 0, 7)
                                                              : random_int(random, 0, 255));
        }
        if (random_int(random, 0, 3) == 0) // what one section lacks, the rest of the file lacks too
            bytes.resize(bytes.size() - static_cast<std::size_t>(random_int(random, 0, 9)));
        for (const auto& [begin, end] : sections) {
            if (end + 4 > bytes.size()) continue;
            const auto sum = static_cast<std::uint32_t>(
                ::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data() + begin), end - begin));
            std::memcpy(bytes.data() + end, &sum, sizeof sum);
        }
        write_bytes(folder / "b.hoct", bytes);
        try {
            const OctreeFile file = read_octree(folder / "b.hoct");
            ++read;
            // A tree: each cell's corners are the nodes at their places, and all nodes are theirs.
            std::set<HashedOctree::NodeNumber> nodes;
            file.tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
                EXPECT_EQ(file.tree.is_divided(cell), !is_leaf);
                const auto corners = file.tree.nodes_of(file.tree.find(cell).value());
                for (int k = 0; k < 8; ++k)
                    EXPECT_EQ(file.tree.find_node(corner_of(cell, k)),
                              corners[static_cast<std::size_t>(k)]);
                nodes.insert(corners.begin(), corners.end());
            });
            EXPECT_EQ(nodes.size(), file.tree.node_count());
            // And what is written of it is what was read.
            std::filesystem::remove(folder / "c.hoct");
            write_octree(file.tree, file.space, file.provenance, folder / "c.hoct");
            if (bytes_of_file(folder / "c.hoct") != bytes) {
                // Text in another order is the one thing that is read and not written so.
                const auto [begin, end] = sections[1];
                const std::string again = bytes_of_file(folder / "c.hoct");
                EXPECT_EQ(again.substr(0, begin), bytes.substr(0, begin));
                EXPECT_EQ(again.substr(end + 4), bytes.substr(end + 4));
            }
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("b.hoct: it"), std::string::npos)
                << error.what();
        }
    }
    return read;
}

} // namespace isocast::test
