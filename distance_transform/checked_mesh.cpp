// Examines and cleans a mesh: one vertex per position, no empty or repeated triangles, a verdict.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/checked_mesh.h"

#include "distance_transform/orientation.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <bit>
#include <cstdint>

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
    // Open addressing, at most half full.
    std::vector<int> slots(2 * std::bit_ceil(mesh.vertices_world.size()), -1);
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
    const auto [a, b, c] = triangle;
    if (a == b || b == c || c == a) return true;
    const Vec3d& origin = mesh.vertices_world[a];
    return (mesh.vertices_world[b] - origin).cross(mesh.vertices_world[c] - origin) ==
           Vec3d::Zero();
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

/// The triangles over merged vertices that have an area and repeat no earlier one.
std::vector<std::array<int, 3>> kept_triangles(const Mesh& mesh, MeshVerdict& verdict) {
    const std::vector<int> first = first_at_position(mesh, verdict);
    std::vector<std::array<int, 3>> kept;
    for (const auto& [a, b, c] : mesh.triangles) {
        const std::array merged = {first[a], first[b], first[c]};
        if (is_degenerate(mesh, merged))
            ++verdict.degenerate_triangles;
        else
            kept.push_back(merged);
    }

    const std::vector<char> is_repeat = repeats(kept, mesh.vertices_world.size());
    verdict.duplicate_triangles = static_cast<int>(std::ranges::count(is_repeat, 1));
    std::size_t next = 0;
    for (std::size_t i = 0; i < kept.size(); ++i)
        if (!is_repeat[i]) kept[next++] = kept[i];
    kept.resize(next);
    return kept;
}

/// `triangles` over the vertices that they use, in the order of `mesh`.
Mesh compacted(const Mesh& mesh, std::vector<std::array<int, 3>> triangles) {
    Mesh result;
    result.triangles = std::move(triangles);
    std::vector<int> renumbered(mesh.vertices_world.size(), -1);
    for (const std::array<int, 3>& triangle : result.triangles)
        for (const int vertex : triangle) renumbered[vertex] = 0;
    for (std::size_t v = 0; v < renumbered.size(); ++v) {
        if (renumbered[v] < 0) continue;
        renumbered[v] = static_cast<int>(result.vertices_world.size());
        result.vertices_world.push_back(mesh.vertices_world[v]);
    }
    for (std::array<int, 3>& triangle : result.triangles)
        for (int& vertex : triangle) vertex = renumbered[vertex];
    return result;
}

void count_edges(const Mesh& mesh, const MeshTopology& topology, MeshVerdict& verdict) {
    DisjointSets boundary(mesh.vertices_world.size());
    std::vector<char> is_on_boundary(mesh.vertices_world.size(), 0);
    for (std::size_t e = 0; e < topology.edge_count(); ++e) {
        const auto halfedges = topology.edge(e);
        if (halfedges.size() == 1) {
            ++verdict.boundary_edges;
            const int from = halfedge_from(mesh, halfedges[0]);
            const int to = halfedge_to(mesh, halfedges[0]);
            is_on_boundary[from] = is_on_boundary[to] = 1;
            boundary.unite(from, to);
        } else if (halfedges.size() > 2) {
            ++verdict.non_manifold_edges;
        } else if (halfedge_from(mesh, halfedges[0]) == halfedge_from(mesh, halfedges[1])) {
            ++verdict.flipped_edges;
        }
    }
    for (int v = 0; v < std::ssize(mesh.vertices_world); ++v)
        verdict.boundary_loops += is_on_boundary[v] && boundary.find(v) == v ? 1 : 0;
}

void count_pinched_vertices(const Mesh& mesh, const MeshTopology& topology, MeshVerdict& verdict) {
    std::vector<int> fan(mesh.vertices_world.size(), -1);
    std::vector<char> is_pinched(mesh.vertices_world.size(), 0);
    for (std::size_t c = 0; c < topology.fan_of_corner.size(); ++c) {
        const int vertex = mesh.triangles[c / 3][c % 3];
        if (fan[vertex] < 0) fan[vertex] = topology.fan_of_corner[c];
        if (fan[vertex] == topology.fan_of_corner[c] || is_pinched[vertex]) continue;
        is_pinched[vertex] = 1;
        ++verdict.non_manifold_vertices;
    }
}

/// Relative to the middle of the box, so that it does not cancel far from the origin.
double signed_volume(const Mesh& mesh) {
    const WorldBox box = bounding_box(mesh);
    const Vec3d middle = box.min + box.size() / 2;
    double six_volumes = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        six_volumes +=
            (mesh.vertices_world[a] - middle)
                .dot((mesh.vertices_world[b] - middle).cross(mesh.vertices_world[c] - middle));
    return six_volumes / 6;
}

template<class IsTurned>
void turn(CheckedMesh& checked, const IsTurned& is_turned) {
    for (std::size_t t = 0; t < checked.mesh.triangles.size(); ++t)
        if (is_turned(t)) std::swap(checked.mesh.triangles[t][1], checked.mesh.triangles[t][2]);
    checked.topology = topology_of(checked.mesh);
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
    result.mesh = compacted(mesh, kept_triangles(mesh, verdict));
    if (result.mesh.triangles.empty())
        throw InputError(fmt::format("the mesh has no triangle with an area ({} triangles given)",
                                     verdict.triangles));

    result.topology = topology_of(result.mesh);
    const MeshTopology& topology = result.topology;
    verdict.shells = topology.shell_count;
    tbb::parallel_invoke([&] { count_edges(result.mesh, topology, verdict); },
                         [&] { count_pinched_vertices(result.mesh, topology, verdict); });
    if (verdict.flipped_edges > 0) orient(result);
    verdict.volume_world = signed_volume(result.mesh);
    if (verdict.is_closed() && verdict.is_oriented() && verdict.volume_world < 0) {
        turn(result, [](std::size_t) { return true; });
        verdict.volume_world = -verdict.volume_world;
        verdict.reversed = true;
    }
    result.warnings = warnings_of(verdict);
    return result;
}

} // namespace isocast
