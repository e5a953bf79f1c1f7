// Octree files: .hoct.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/hashed_octree.h"

#include <filesystem>
#include <map>
#include <string>

namespace isocast {

/// What an octree file holds. Nodes have the numbers 0, 1, 2, … in the order of visit_nodes.
struct OctreeFile {
    HashedOctree tree;
    GridSpace space;                               // of the tree's positions
    std::map<std::string, std::string> provenance; // what it was made from, and how
};

/// Reads a file of the format that docs/octree.md describes.
/// throws  InputError that names the file and the cause if it is damaged in any way: each of its
///         parts has a checksum, and is checked for what it says too; ResourceError if there is no
///         memory for it
OctreeFile read_octree(const std::filesystem::path& path);

/// Writes it. The file appears whole or not at all.
/// throws  InputError if the folder does not exist, or a key or value of `provenance` has a line
///         end or a key has " = " in it; ResourceError if the disk is full
void write_octree(const HashedOctree& tree, const GridSpace& space,
                  const std::map<std::string, std::string>& provenance,
                  const std::filesystem::path& path);

} // namespace isocast
