// Which triangles must be turned so that neighbours agree on the outside.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh_topology.h"

namespace isocast {

struct Orientation {
    /// False if no choice of turns suits all edges: a Möbius strip, a Klein bottle.
    bool is_possible = true;
    std::vector<char> is_turned; // by triangle; the lesser part of each patch is turned
    int turned_count = 0;
};

/// Looks across edges of exactly two triangles only; others part the mesh into patches.
Orientation orientation_of(const Mesh& mesh, const MeshTopology& topology);

} // namespace isocast
