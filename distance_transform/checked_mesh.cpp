// Examines and cleans a mesh: one vertex per position, no empty or repeated triangles, a verdict.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/checked_mesh.h"

#include "distance_transform/orientation.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>

namespace isocast {

namespace {

std::string counted(int count, std::string_view one, std::string_view many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::vector<char> used_vertices(const Mesh& mesh) {
    std::vector<char> is_used(mesh.vertices_world.size(), 0);
    for (const std::array<int, 3>& triangle : mesh.triangles)
        for (const int vertex : triangle) is_used[vertex] = 1;
    return is_used;
}

std::uint64_t hash_of(const Vec3d& p) {
    std::uint64_t hash = 0;
    for (const double x : p) {
        // + 0.0 makes -0 and +0 one; the odd factor is 2^64 over the golden ratio.
        hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15;
        hash ^= hash >> 29;
    }
    return hash;
}

/// For each vertex in use the first one at the same position (+0 equals -0); counts the others.
std::vector<int> first_at_position(const Mesh& mesh, MeshVerdict& verdict) {
    const std::vector<char> is_used = used_vertices(mesh);
    std::vector<int> first(mesh.vertices_world.size(), -1);
    // Open addressing, at most two thirds full.
    std::vector<int> slots(std::bit_ceil(3 * mesh.vertices_world.size() / 2 + 1), -1);
    for (int v = 0; v < std::ssize(mesh.vertices_world); ++v) {
        if (!is_used[v]) {
            ++verdict.unreferenced_vertices;
            continue;
        }
        const Vec3d& p = mesh.vertices_world[v];
        std::size_t slot = hash_of(p) & (slots.size() - 1);
        while (slots[slot] >= 0 && mesh.vertices_world[slots[slot]] != p)
            slot = (slot + 1) & (slots.size() - 1);
        if (slots[slot] < 0)
            slots[slot] = v;
        else
            ++verdict.duplicate_vertices;
        first[v] = slots[slot];
    }
    return first;
}

bool is_degenerate(const Mesh& mesh, const std::array<int, 3>& triangle) {
    const auto [i, j, k] = triangle;
    const Vec3d& a = mesh.vertices_world[i];
    const Vec3d& b = mesh.vertices_world[j];
    const Vec3d& c = mesh.vertices_world[k];
    // Corners that are not finite make no cross product 0.
    return i == j || j == k || k == i || a == b || b == c || c == a ||
           (b - a).cross(c - a) == Vec3d::Zero();
}

/// Of the merged triangle: its vertices in ascending order.
std::array<int, 3> sorted_corners(std::array<int, 3> t) {
    if (t[0] > t[1]) std::swap(t[0], t[1]);
    if (t[1] > t[2]) std::swap(t[1], t[2]);
    if (t[0] > t[1]) std::swap(t[0], t[1]);
    return t;
}

/// Whether a triangle has the vertices of an earlier one.
std::vector<char> repeats(const std::vector<std::array<int, 3>>& triangles,
                          std::size_t vertex_count) {
    struct Corners {
        int middle;
        int greatest;
        std::uint32_t triangle;
        auto operator<=>(const Corners&) const = default;
    };
    const Buckets by_least = buckets_of(triangles.size(), vertex_count, [&](std::size_t t) {
        return std::min({triangles[t][0], triangles[t][1], triangles[t][2]});
    });
    std::vector<char> is_repeat(triangles.size(), 0);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertex_count, 1024), [&](auto& range) {
        std::vector<Corners> corners;
        for (std::size_t v = range.begin(); v < range.end(); ++v) {
            corners.clear();
            for (std::uint32_t i = by_least.begin[v]; i < by_least.begin[v + 1]; ++i) {
                const std::uint32_t t = by_least.order[i];
                const auto [least, middle, greatest] = sorted_corners(triangles[t]);
                corners.push_back({middle, greatest, t});
            }
            std::ranges::sort(corners);
            for (std::size_t i = 1; i < corners.size(); ++i)
                if (corners[i].middle == corners[i - 1].middle &&
                    corners[i].greatest == corners[i - 1].greatest)
                    is_repeat[corners[i].triangle] = 1;
        }
    });
    return is_repeat;
}

/// Takes each vertex for the first at its position, and leaves out vertices that no triangle uses.
void compact(Mesh& mesh, const std::vector<int>& first) {
    std::vector<int> renumbered(first.size(), -1);
    for (const std::array<int, 3>& triangle : mesh.triangles)
        for (const int vertex : triangle) renumbered[first[vertex]] = 0;
    int count = 0;
    for (std::size_t v = 0; v < renumbered.size(); ++v) {
        if (renumbered[v] < 0) continue;
        mesh.vertices_world[count] = mesh.vertices_world[v];
        renumbered[v] = count++;
    }
    mesh.vertices_world.resize(count);
    for (std::array<int, 3>& triangle : mesh.triangles)
        for (int& vertex : triangle) vertex = renumbered[first[vertex]];
}

/// The triangles with an area over merged vertices.
Mesh merged(const Mesh& mesh, MeshVerdict& verdict) {
    Mesh result;
    std::vector<int> first;
    tbb::parallel_invoke(
        [&] {
            first = first_at_position(mesh, verdict);
            result.vertices_world = mesh.vertices_world;
        },
        [&] {
            result.triangles.reserve(mesh.triangles.size());
            std::ranges::copy_if(
                mesh.triangles, std::back_inserter(result.triangles),
                [&](const auto& triangle) { return !is_degenerate(mesh, triangle); });
        });
    verdict.degenerate_triangles =
        static_cast<int>(mesh.triangles.size() - result.triangles.size());
    const int vertices_to_drop = verdict.unreferenced_vertices + verdict.duplicate_vertices;
    if (vertices_to_drop + verdict.degenerate_triangles > 0) compact(result, first);
    return result;
}

int opposite(const Mesh& mesh, std::uint32_t halfedge) {
    return mesh.triangles[halfedge / 3][(halfedge % 3 + 2) % 3];
}

struct EdgeCounts {
    int boundary = 0;
    int non_manifold = 0;
    int flipped = 0;
    int folded = 0; // between two triangles of the same vertices

    EdgeCounts operator+(const EdgeCounts& other) const {
        return {boundary + other.boundary, non_manifold + other.non_manifold,
                flipped + other.flipped, folded + other.folded};
    }
};

EdgeCounts edge_counts(const Mesh& mesh, const MeshTopology& topology) {
    const auto add_edges = [&](const auto& range, EdgeCounts counts) {
        for (std::size_t e = range.begin(); e < range.end(); ++e) {
            const auto halfedges = topology.edge(e);
            if (halfedges.size() != 2) {
                ++(halfedges.size() == 1 ? counts.boundary : counts.non_manifold);
                continue;
            }
            const std::uint32_t a = halfedges[0];
            const std::uint32_t b = halfedges[1];
            counts.flipped += halfedge_from(mesh, a) == halfedge_from(mesh, b) ? 1 : 0;
            counts.folded += opposite(mesh, a) == opposite(mesh, b) ? 1 : 0;
        }
        return counts;
    };
    return tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, topology.edge_count(), 4096),
                                EdgeCounts{}, add_edges, std::plus<>());
}

int boundary_loops(const Mesh& mesh, const MeshTopology& topology) {
    DisjointSets boundary(mesh.vertices_world.size());
    std::vector<char> is_on_boundary(mesh.vertices_world.size(), 0);
    for (std::size_t e = 0; e < topology.edge_count(); ++e) {
        const auto halfedges = topology.edge(e);
        if (halfedges.size() != 1) continue;
        const int from = halfedge_from(mesh, halfedges[0]);
        const int to = halfedge_to(mesh, halfedges[0]);
        is_on_boundary[from] = is_on_boundary[to] = 1;
        boundary.unite(from, to);
    }
    int count = 0;
    for (int v = 0; v < std::ssize(mesh.vertices_world); ++v)
        count += is_on_boundary[v] && boundary.find(v) == v ? 1 : 0;
    return count;
}

/// Vertices of more than one fan.
int pinched_vertices(const Mesh& mesh, const MeshTopology& topology) {
    std::vector<int> fans(mesh.vertices_world.size());
    for (std::size_t f = 0; f < topology.fan_begin.size() - 1; ++f)
        ++fans[halfedge_from(mesh, topology.fan(f)[0])];
    return static_cast<int>(std::ranges::count_if(fans, [](int count) { return count > 1; }));
}

/// Relative to the middle of the box, so that it does not cancel far from the origin.
double signed_volume(const Mesh& mesh) {
    WorldBox box{mesh.vertices_world[0], mesh.vertices_world[0]}; // all its vertices are in use
    for (const Vec3d& p : mesh.vertices_world) {
        box.min = box.min.cwiseMin(p);
        box.max = box.max.cwiseMax(p);
    }
    const Vec3d middle = box.min + box.size() / 2;
    double six_volumes = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        six_volumes +=
            (mesh.vertices_world[a] - middle)
                .dot((mesh.vertices_world[b] - middle).cross(mesh.vertices_world[c] - middle));
    return six_volumes / 6;
}

/// Finds the topology and the volume.
void examine(CheckedMesh& checked) {
    tbb::parallel_invoke([&] { checked.topology = topology_of(checked.mesh); },
                         [&] { checked.verdict.volume_world = signed_volume(checked.mesh); });
}

/// Takes out triangles that repeat an earlier one. returns  whether there are any
bool remove_repeats(CheckedMesh& checked) {
    std::vector<std::array<int, 3>>& triangles = checked.mesh.triangles;
    const std::vector<char> is_repeat = repeats(triangles, checked.mesh.vertices_world.size());
    std::size_t kept = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t)
        if (!is_repeat[t]) triangles[kept++] = triangles[t];
    checked.verdict.duplicate_triangles = static_cast<int>(triangles.size() - kept);
    triangles.resize(kept);
    return checked.verdict.duplicate_triangles > 0;
}

template<class IsTurned>
void turn(CheckedMesh& checked, const IsTurned& is_turned) {
    for (std::size_t t = 0; t < checked.mesh.triangles.size(); ++t)
        if (is_turned(t)) std::swap(checked.mesh.triangles[t][1], checked.mesh.triangles[t][2]);
    examine(checked);
}

/// Turns the triangles that disagree with their neighbours, if all can be made to agree.
void orient(CheckedMesh& checked) {
    const Orientation orientation = orientation_of(checked.mesh, checked.topology);
    checked.verdict.is_orientable = orientation.is_possible;
    if (!orientation.is_possible) return;
    checked.verdict.turned_triangles = orientation.turned_count;
    turn(checked, [&](std::size_t t) { return orientation.is_turned[t] != 0; });
}

std::vector<std::string> warnings_of(const MeshVerdict& verdict) {
    std::vector<std::string> warnings;
    const auto warn = [&](int count, std::string_view one, std::string_view many,
                          std::string_view rest) {
        if (count > 0) warnings.push_back(counted(count, one, many) + std::string(rest));
    };
    warn(verdict.unreferenced_vertices, "vertex is", "vertices are", " used by no triangle.");
    warn(verdict.degenerate_triangles, "triangle has", "triangles have", " no area: left out.");
    warn(verdict.duplicate_triangles, "triangle repeats", "triangles repeat",
         " an earlier one: left out.");
    if (verdict.boundary_edges > 0)
        warnings.push_back(
            fmt::format("The mesh is open: {} in {}.",
                        counted(verdict.boundary_edges, "boundary edge", "boundary edges"),
                        counted(verdict.boundary_loops, "hole", "holes")));
    warn(verdict.non_manifold_edges, "edge joins", "edges join", " more than two triangles.");
    if (!verdict.is_orientable)
        warnings.push_back("The surface has one side only, like a Möbius strip: it has no inside.");
    else
        warn(verdict.turned_triangles, "triangle was", "triangles were",
             " turned round to agree with the neighbours.");
    warn(verdict.non_manifold_vertices, "vertex joins", "vertices join",
         " parts of the surface that share no edge there.");
    if (verdict.reversed)
        warnings.push_back("The mesh was inside out; all its triangles were turned round.");
    return warnings;
}

} // namespace

std::string MeshVerdict::summary() const {
    std::string text;
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
    if (boundary_edges > 0)
        add(fmt::format("open: {} in {}",
                        counted(boundary_edges, "boundary edge", "boundary edges"),
                        counted(boundary_loops, "hole", "holes")));
    else if (is_closed())
        add("closed");
    if (non_manifold_edges > 0)
        add(counted(non_manifold_edges, "non-manifold edge", "non-manifold edges"));
    if (!is_orientable)
        add("not orientable");
    else if (turned_triangles > 0)
        add(counted(turned_triangles, "triangle turned", "triangles turned"));
    else if (is_closed())
        add("oriented");
    if (non_manifold_vertices > 0)
        add(counted(non_manifold_vertices, "non-manifold vertex", "non-manifold vertices"));
    else if (is_closed())
        add("manifold");
    return text;
}

CheckedMesh check(const Mesh& mesh) {
    CheckedMesh result;
    MeshVerdict& verdict = result.verdict;
    verdict.vertices = static_cast<int>(mesh.vertices_world.size());
    verdict.triangles = static_cast<int>(mesh.triangles.size());
    result.mesh = merged(mesh, verdict);
    if (result.mesh.triangles.empty())
        throw InputError(fmt::format("the mesh has no triangle with an area ({} triangles given)",
                                     verdict.triangles));

    examine(result);
    EdgeCounts edges = edge_counts(result.mesh, result.topology);
    // A triangle that repeats another one shares its edges.
    if (edges.folded + edges.non_manifold > 0 && remove_repeats(result)) {
        examine(result);
        edges = edge_counts(result.mesh, result.topology);
    }
    verdict.boundary_edges = edges.boundary;
    verdict.non_manifold_edges = edges.non_manifold;
    verdict.flipped_edges = edges.flipped;
    verdict.shells = result.topology.shell_count;
    if (edges.boundary > 0) verdict.boundary_loops = boundary_loops(result.mesh, result.topology);
    if (result.topology.fan_count > std::ssize(result.mesh.vertices_world))
        verdict.non_manifold_vertices = pinched_vertices(result.mesh, result.topology);
    if (edges.flipped > 0) orient(result);
    if (verdict.is_closed() && verdict.is_oriented() && verdict.volume_world < 0) {
        turn(result, [](std::size_t) { return true; });
        verdict.reversed = true;
    }
    result.warnings = warnings_of(verdict);
    return result;
}

} // namespace isocast
