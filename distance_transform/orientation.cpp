// Which triangles must be turned so that neighbours agree on the outside.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/orientation.h"

namespace isocast {

namespace {

struct Neighbour {
    std::uint32_t triangle = 0;
    bool is_present = false;
    bool disagrees = false; // both run along the edge in the same direction
};

std::vector<std::array<Neighbour, 3>> neighbours_of(const Mesh& mesh,
                                                    const MeshTopology& topology) {
    std::vector<std::array<Neighbour, 3>> neighbours(mesh.triangles.size());
    for (std::size_t e = 0; e < topology.edge_count(); ++e) {
        const auto halfedges = topology.edge(e);
        if (halfedges.size() != 2) continue;
        const bool disagrees =
            halfedge_from(mesh, halfedges[0]) == halfedge_from(mesh, halfedges[1]);
        for (int side = 0; side < 2; ++side)
            neighbours[halfedges[side] / 3][halfedges[side] % 3] = {halfedges[1 - side] / 3, true,
                                                                    disagrees};
    }
    return neighbours;
}

} // namespace

Orientation orientation_of(const Mesh& mesh, const MeshTopology& topology) {
    const auto neighbours = neighbours_of(mesh, topology);
    Orientation result;
    result.is_turned.assign(mesh.triangles.size(), 0);
    std::vector<char> is_seen(mesh.triangles.size(), 0);
    std::vector<std::uint32_t> patch;
    for (std::uint32_t seed = 0; seed < mesh.triangles.size(); ++seed) {
        if (is_seen[seed]) continue;
        patch.assign(1, seed);
        is_seen[seed] = 1;
        std::size_t turned = 0;
        for (std::size_t next = 0; next < patch.size(); ++next) {
            const std::uint32_t t = patch[next];
            turned += result.is_turned[t];
            for (const Neighbour& neighbour : neighbours[t]) {
                if (!neighbour.is_present) continue;
                const char wanted = result.is_turned[t] ^ char { neighbour.disagrees };
                if (!is_seen[neighbour.triangle]) {
                    is_seen[neighbour.triangle] = 1;
                    result.is_turned[neighbour.triangle] = wanted;
                    patch.push_back(neighbour.triangle);
                } else if (result.is_turned[neighbour.triangle] != wanted) {
                    result.is_possible = false;
                }
            }
        }
        if (2 * turned > patch.size()) {
            for (const std::uint32_t t : patch) result.is_turned[t] ^= 1;
            turned = patch.size() - turned;
        }
        result.turned_count += static_cast<int>(turned);
    }
    return result;
}

} // namespace isocast
