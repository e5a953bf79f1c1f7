// Which triangles of a mesh meet: edges and fans around each vertex, shells by disjoint sets.
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
    if (parent_[a] == parent_[b]) return; // the most frequent case, when sets are large
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
}

namespace {

/// Set in a half-edge that is the first of its edge, until the edges are numbered.
constexpr std::uint32_t first_of_edge = std::uint32_t{1} << 31;

/// Joins the corners around a vertex across the edges at it.
class VertexJoiner {
public:
    VertexJoiner(const Mesh& mesh, MeshTopology& topology) : mesh_(mesh), topology_(topology) {}

    /// Tells the vertex's `corners` the least corner of their fan, and writes the half-edges of the
    /// edges to greater vertices. returns  past the last one written
    std::uint32_t* join(int vertex, std::span<const std::uint32_t> corners,
                        std::uint32_t* halfedges) {
        if (corners.empty()) return halfedges;
        look_around(corners);
        if (!walk_around(vertex)) return join_any(vertex, corners, halfedges);
        for (const std::uint32_t corner : corners)
            topology_.fan_of_corner[corner] = static_cast<int>(corners[0]);
        const auto edges = std::span(edges_).first(edge_count_);
        // So few are placed faster than sorted; many do not come round (see place_by_end_).
        for (const Edge& edge : edges) {
            std::size_t place = 0;
            for (const Edge& another : edges) place += another.end < edge.end ? 2 : 0;
            halfedges[place] = std::min(edge.out, edge.in) | first_of_edge;
            halfedges[place + 1] = std::max(edge.out, edge.in);
        }
        return halfedges + 2 * edges.size();
    }

private:
    /// Of a triangle at the vertex: its half-edges from there and to there, and their other ends.
    struct Sides {
        int out_end;
        int in_end;
        std::uint32_t out;
        std::uint32_t in;
    };
    struct Edge {
        int end;
        std::uint32_t out;
        std::uint32_t in;
    };
    struct Spoke {
        int end;
        std::uint32_t halfedge;
        int corner; // by its place
        auto operator<=>(const Spoke&) const = default;
    };

    void look_around(std::span<const std::uint32_t> corners) {
        sides_.resize(corners.size());
        for (std::size_t i = 0; i < corners.size(); ++i) {
            static constexpr std::array<std::uint32_t, 3> next = {1, 2, 0};
            static constexpr std::array<std::uint32_t, 3> previous = {2, 0, 1};
            const std::array<int, 3>& triangle = mesh_.triangles[corners[i] / 3];
            const std::uint32_t k = corners[i] % 3;
            sides_[i] = {triangle[next[k]], triangle[previous[k]], corners[i],
                         corners[i] - k + previous[k]};
        }
    }

    /// Whether the corners are one closed fan of triangles that agree in their orientation; if so,
    /// finds the edges to greater vertices.
    bool walk_around(int vertex) {
        const auto count = static_cast<std::uint32_t>(sides_.size());
        for (std::uint32_t i = 0; i < count; ++i)
            place_by_end_[sides_[i].out_end % place_by_end_.size()] = i;
        edges_.resize(count);
        edge_count_ = 0;
        std::uint32_t at = 0;
        std::uint32_t steps = 0;
        do {
            const int end = sides_[at].in_end;
            const std::uint32_t to = place_by_end_[end % place_by_end_.size()];
            // A corner of another vertex, or of another end with the same last digits.
            if (to >= count || sides_[to].out_end != end) return false;
            edges_[edge_count_] = {end, sides_[to].out, sides_[at].in};
            edge_count_ += end > vertex ? 1 : 0;
            at = to;
            ++steps;
        } while (at != 0 && steps < count);
        return at == 0 && steps == count;
    }

    std::uint32_t* join_any(int vertex, std::span<const std::uint32_t> corners,
                            std::uint32_t* halfedges) {
        spokes_.clear();
        for (int i = 0; i < std::ssize(corners); ++i) {
            spokes_.push_back({sides_[i].out_end, sides_[i].out, i});
            spokes_.push_back({sides_[i].in_end, sides_[i].in, i});
        }
        std::ranges::sort(spokes_);
        DisjointSets fans(corners.size());
        for (std::size_t i = 0; i < spokes_.size(); ++i) {
            const bool is_first = i == 0 || spokes_[i].end != spokes_[i - 1].end;
            if (!is_first) fans.unite(spokes_[i - 1].corner, spokes_[i].corner);
            if (spokes_[i].end > vertex)
                *halfedges++ = spokes_[i].halfedge | (is_first ? first_of_edge : 0);
        }
        for (int i = 0; i < std::ssize(corners); ++i)
            topology_.fan_of_corner[corners[i]] = static_cast<int>(corners[fans.find(i)]);
        return halfedges;
    }

    const Mesh& mesh_;
    MeshTopology& topology_;
    std::vector<Sides> sides_;
    std::vector<Edge> edges_;
    std::size_t edge_count_ = 0;
    std::vector<Spoke> spokes_;
    /// Which corner's half-edge leads to an end, by the end's last digits: 1024 are many more than
    /// triangles around most vertices, and lie in the nearest cache.
    std::array<std::uint32_t, 1024> place_by_end_{};
};

/// For each vertex the half-edges before those of the edges to greater vertices.
std::vector<std::uint32_t> halfedges_before(const Mesh& mesh) {
    std::vector<std::uint32_t> before(mesh.vertices_world.size() + 1);
    for (const auto& [a, b, c] : mesh.triangles)
        for (const int least : {std::min(a, b), std::min(b, c), std::min(c, a)})
            ++before[least + 1];
    std::inclusive_scan(before.begin(), before.end(), before.begin());
    return before;
}

void number_edges(MeshTopology& topology) {
    topology.edge_begin.reserve(1 + std::ranges::count_if(topology.halfedges, [](std::uint32_t h) {
                                    return (h & first_of_edge) != 0;
                                }));
    for (std::uint32_t i = 0; i < topology.halfedges.size(); ++i) {
        if ((topology.halfedges[i] & first_of_edge) == 0) continue;
        topology.halfedges[i] ^= first_of_edge;
        topology.edge_begin.push_back(i);
    }
    topology.edge_begin.push_back(static_cast<std::uint32_t>(topology.halfedges.size()));
}

/// Numbers the fans in the order of their least corners, by which they are told before.
void number_fans(MeshTopology& topology) {
    std::vector<int>& fan_of_corner = topology.fan_of_corner;
    for (int c = 0; c < std::ssize(fan_of_corner); ++c) {
        const int least = fan_of_corner[c];
        fan_of_corner[c] = least == c ? topology.fan_count : fan_of_corner[least];
        topology.fan_count += least == c ? 1 : 0;
    }
}

/// Fans that share a triangle are of one shell, and there are fewer of them than triangles.
void count_shells(MeshTopology& topology) {
    DisjointSets shells(topology.fan_count);
    for (std::size_t c = 0; c < topology.fan_of_corner.size(); c += 3) {
        shells.unite(topology.fan_of_corner[c], topology.fan_of_corner[c + 1]);
        shells.unite(topology.fan_of_corner[c], topology.fan_of_corner[c + 2]);
    }
    for (int f = 0; f < topology.fan_count; ++f)
        topology.shell_count += shells.find(f) == f ? 1 : 0;
}

} // namespace

MeshTopology topology_of(const Mesh& mesh) {
    const std::size_t corner_count = 3 * mesh.triangles.size();
    if (corner_count > std::numeric_limits<int>::max())
        throw ResourceError(
            fmt::format("the mesh has too many triangles ({})", mesh.triangles.size()));
    const std::size_t vertex_count = mesh.vertices_world.size();
    MeshTopology topology;
    Buckets by_vertex;
    std::vector<std::uint32_t> before;
    tbb::parallel_invoke(
        [&] {
            by_vertex = buckets_of(corner_count, vertex_count, [&](std::size_t c) {
                return halfedge_from(mesh, static_cast<std::uint32_t>(c));
            });
        },
        [&] {
            before = halfedges_before(mesh);
            topology.halfedges.resize(corner_count);
            topology.fan_of_corner.resize(corner_count);
        });
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertex_count, 1024), [&](auto& range) {
        VertexJoiner joiner(mesh, topology);
        std::uint32_t* halfedges = topology.halfedges.data() + before[range.begin()];
        for (std::size_t v = range.begin(); v < range.end(); ++v)
            halfedges = joiner.join(
                static_cast<int>(v),
                std::span(by_vertex.order)
                    .subspan(by_vertex.begin[v], by_vertex.begin[v + 1] - by_vertex.begin[v]),
                halfedges);
    });
    number_fans(topology);
    const auto fan_of = [&](std::size_t c) { return topology.fan_of_corner[c]; };
    tbb::parallel_invoke([&] { count_shells(topology); },
                         [&] {
                             number_edges(topology);
                             Buckets fans = buckets_of(corner_count, topology.fan_count, fan_of,
                                                       std::move(by_vertex));
                             topology.fan_corners = std::move(fans.order);
                             topology.fan_begin = std::move(fans.begin);
                         });
    return topology;
}

} // namespace isocast
