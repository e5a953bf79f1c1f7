// Which triangles of a mesh meet, across edges and around vertices.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <cstdint>
#include <span>

namespace isocast {

/// Half-edge 3 t + k runs from corner k of triangle t to its next corner. Needs triangles with
/// three different vertices each.
struct MeshTopology {
    /// All half-edges, those of one edge next to each other, each edge's in ascending order.
    std::vector<std::uint32_t> halfedges;
    /// Edge e's half-edges are those from edge_begin[e] to edge_begin[e + 1].
    std::vector<std::uint32_t> edge_begin;
    /// The fan of corner 3 t + k: triangles around its vertex that connect through edges at it.
    std::vector<int> fan_of_corner;
    int fan_count = 0;
    /// All corners, those of one fan next to each other, each fan's in ascending order. Fans are
    /// numbered by their least corner.
    std::vector<std::uint32_t> fan_corners;
    /// Fan f's corners are those from fan_begin[f] to fan_begin[f + 1].
    std::vector<std::uint32_t> fan_begin;
    /// Components of triangles that connect through edges.
    int shell_count = 0;

    std::size_t edge_count() const { return edge_begin.size() - 1; }
    std::span<const std::uint32_t> edge(std::size_t e) const {
        return std::span(halfedges).subspan(edge_begin[e], edge_begin[e + 1] - edge_begin[e]);
    }
    std::span<const std::uint32_t> fan(std::size_t f) const {
        return std::span(fan_corners).subspan(fan_begin[f], fan_begin[f + 1] - fan_begin[f]);
    }
};

/// throws  ResourceError for more triangles than 32 bits of half-edges can number
MeshTopology topology_of(const Mesh& mesh);

inline int halfedge_from(const Mesh& mesh, std::uint32_t halfedge) {
    return mesh.triangles[halfedge / 3][halfedge % 3];
}
inline int halfedge_to(const Mesh& mesh, std::uint32_t halfedge) {
    return mesh.triangles[halfedge / 3][(halfedge % 3 + 1) % 3];
}

/// The numbers 0 … count - 1 by key, each bucket's in ascending order: one pass to count, one to
/// fill.
struct Buckets {
    std::vector<std::uint32_t> order;
    /// Bucket k is order[begin[k]] … order[begin[k + 1] - 1].
    std::vector<std::uint32_t> begin;
};

/// key      of a number, in 0 … key_count - 1
/// buckets  whose memory is used again
template<class Key>
Buckets buckets_of(std::size_t count, std::size_t key_count, const Key& key, Buckets buckets = {}) {
    buckets.order.resize(count);
    buckets.begin.assign(key_count + 1, 0);
    for (std::size_t i = 0; i < count; ++i) ++buckets.begin[key(i) + 1];
    for (std::size_t k = 0; k < key_count; ++k) buckets.begin[k + 1] += buckets.begin[k];
    std::vector<std::uint32_t> next(buckets.begin.begin(), buckets.begin.end() - 1);
    for (std::size_t i = 0; i < count; ++i)
        buckets.order[next[key(i)]++] = static_cast<std::uint32_t>(i);
    return buckets;
}

/// Sets of integers that grow together (union by least member, path halving).
class DisjointSets {
public:
    explicit DisjointSets(std::size_t count);
    int find(int member);
    void unite(int a, int b);

private:
    std::vector<int> parent_;
};

} // namespace isocast
