// Nodes that hang on edges and faces of coarser cells, kept up to date as an octree is divided.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/hashed_octree.h"

#include <array>

namespace isocast {

/// Lets each hanging node hold what its coarser neighbour has there (thesis 3.4.1).
///
/// A node hangs if one of the cells that have it inside an edge or a face is not divided: those
/// that are get counted as they are divided, so that nothing is looked up.
class HangingNodes {
public:
    /// Cells that were divided; each is told once, and none may be merged.
    void add(const HashedOctree& tree, const OctreeCell& divided);
    /// Coarse nodes first. Those that hung and no longer do are sampled again.
    ///
    /// changed  is called with the positions of nodes that hold something else than before
    void constrain(HashedOctree& tree, const HashedOctree::NodeSampler& sampler,
                   const std::function<void(const Index3& position)>& changed);

    /// At most.
    static constexpr std::size_t bytes_a_node = 33;

private:
    /// In the middle of an edge or a face, half way between two other nodes.
    struct Middle {
        HashedOctree::NodeNumber node, below, above;
        Index3 position;
        int axis;  // that on which they lie
        int cells; // that have it there
    };
    static_assert(sizeof(Middle) + 1 == bytes_a_node);
    std::vector<std::uint8_t> divided_; // of these cells, by node
    /// By the level of the cells: of edges, and of faces, which lie between those of edges.
    std::array<std::array<std::vector<Middle>, 2>, greatest_octree_depth + 1> middles_;
};

} // namespace isocast
