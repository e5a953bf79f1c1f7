// The nodes of a kD-tree over the triangles of a mesh, and how they are made.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <cstdint>

namespace isocast {

/// What becomes of the triangles that the split plane of a node cuts.
enum class KdVariant {
    Overlapping,     // each child has a plane of its own, and they may overlap (thesis 4.1)
    ObjectsAtNodes,  // one plane; they stay at the node
    SplitReferences, // one plane; both children refer to them
};

/// A node's left child is the next node.
struct KdNode {
    double left_end = 0;    // the left child's triangles lie below it along the axis
    double right_begin = 0; // the right child's above it; overlap: right_begin < left_end
    std::int32_t first = 0; // of the triangles that stay at the node
    std::int32_t count = 0;
    std::int32_t right = 0; // child; 0 at a leaf
    std::int32_t axis = 0;
};

struct KdNodes {
    std::vector<KdNode> nodes;           // the root first
    std::vector<std::int32_t> triangles; // as the nodes list them
};

/// Levels of nodes: more than halving 2^31 triangles needs, so that no input makes it deeper.
inline constexpr int greatest_kd_depth = 64;

/// source    Sigg 2006 (thesis), 4.1.2: median of a random sample, partition into left, right and
///           middle until even, then the sweep over the sorted middle. Its measure of the best
///           configuration is left open; here it is the expected number of triangles tested, a
///           child being visited in proportion to the sum of its box's edges
/// accuracy  the same tree for any number of threads
KdNodes build_kd_nodes(const Mesh& mesh, KdVariant variant);

} // namespace isocast
