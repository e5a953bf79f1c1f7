// Which triangles of a mesh meet: edges by their lesser vertex, fans and shells by disjoint sets.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh_topology.h"

#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace isocast {

DisjointSets::DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
}

int DisjointSets::find(int member) {
    while (parent_[member] != member) {
        parent_[member] = parent_[parent_[member]];
        member = parent_[member];
    }
    return member;
}

void DisjointSets::unite(int a, int b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
}

namespace {

struct EdgeUse {
    int greatest; // of the edge's vertices
    std::uint32_t halfedge;
    auto operator<=>(const EdgeUse&) const = default;
};

/// The corner of triangle `halfedge / 3` at which `vertex` stands; it is an end of the half-edge.
int corner_at(const Mesh& mesh, std::uint32_t halfedge, int vertex) {
    const auto first = static_cast<int>(halfedge / 3 * 3);
    const auto k = static_cast<int>(halfedge % 3);
    return first + (mesh.triangles[halfedge / 3][k] == vertex ? k : (k + 1) % 3);
}

/// Calls visit(a, b) for half-edges that follow each other at an edge.
template<class Visit>
void for_each_meeting(const MeshTopology& topology, const Visit& visit) {
    for (std::size_t e = 0; e < topology.edge_count(); ++e) {
        const auto halfedges = topology.edge(e);
        for (std::size_t i = 1; i < halfedges.size(); ++i) visit(halfedges[i - 1], halfedges[i]);
    }
}

void find_fans(const Mesh& mesh, MeshTopology& topology) {
    DisjointSets fans(topology.halfedges.size());
    for_each_meeting(topology, [&](std::uint32_t a, std::uint32_t b) {
        for (const int vertex : {halfedge_from(mesh, a), halfedge_to(mesh, a)})
            fans.unite(corner_at(mesh, a, vertex), corner_at(mesh, b, vertex));
    });
    // A set's least member names it, so that one pass numbers the sets in order.
    topology.fan_of_corner.resize(topology.halfedges.size());
    for (int c = 0; c < std::ssize(topology.fan_of_corner); ++c) {
        const int root = fans.find(c);
        topology.fan_of_corner[c] = root == c ? topology.fan_count++ : topology.fan_of_corner[root];
    }
}

void count_shells(const Mesh& mesh, MeshTopology& topology) {
    DisjointSets shells(mesh.triangles.size());
    for_each_meeting(topology, [&](std::uint32_t a, std::uint32_t b) {
        shells.unite(static_cast<int>(a / 3), static_cast<int>(b / 3));
    });
    for (int t = 0; t < std::ssize(mesh.triangles); ++t)
        topology.shell_count += shells.find(t) == t ? 1 : 0;
}

} // namespace

MeshTopology topology_of(const Mesh& mesh) {
    const std::size_t corner_count = 3 * mesh.triangles.size();
    if (corner_count > std::numeric_limits<int>::max())
        throw ResourceError(
            fmt::format("the mesh has too many triangles ({})", mesh.triangles.size()));
    const auto ends = [&](std::uint32_t h) {
        return std::minmax({halfedge_from(mesh, h), halfedge_to(mesh, h)});
    };
    const Buckets by_least =
        buckets_of(corner_count, mesh.vertices_world.size(),
                   [&](std::size_t h) { return ends(static_cast<std::uint32_t>(h)).first; });
    std::vector<EdgeUse> uses(corner_count);
    tbb::parallel_for(std::size_t{0}, mesh.vertices_world.size(), [&](std::size_t vertex) {
        for (std::uint32_t i = by_least.begin[vertex]; i < by_least.begin[vertex + 1]; ++i)
            uses[i] = {ends(by_least.order[i]).second, by_least.order[i]};
        std::sort(uses.begin() + by_least.begin[vertex], uses.begin() + by_least.begin[vertex + 1]);
    });

    MeshTopology topology;
    topology.halfedges.reserve(corner_count);
    for (int least = 0; least < std::ssize(mesh.vertices_world); ++least) {
        for (std::uint32_t i = by_least.begin[least]; i < by_least.begin[least + 1]; ++i) {
            topology.halfedges.push_back(uses[i].halfedge);
            if (i == by_least.begin[least] || uses[i].greatest != uses[i - 1].greatest)
                topology.edge_begin.push_back(i);
        }
    }
    topology.edge_begin.push_back(static_cast<std::uint32_t>(corner_count));
    tbb::parallel_invoke([&] { find_fans(mesh, topology); }, [&] { count_shells(mesh, topology); });
    Buckets fans = buckets_of(topology.fan_of_corner.size(), std::size_t(topology.fan_count), [&](std::size_t c) { return topology.fan_of_corner[c]; });
    topology.fan_corners = std::move(fans.order);
    topology.fan_begin = std::move(fans.begin);
    return topology;
}

} // namespace isocast
