// The Voronoi sites of a mesh: its faces, edges and vertices, and where each can be nearest.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh_topology.h"
#include "distance_transform/scan_kernel.h"
#include "volume/fresh_memory.h"

namespace isocast {

/// The faces by triangle, the edges by edge of the topology, the vertices by fan. A site that
/// cannot hold the nearest point of any sample has an empty region: low > high.
struct Sites {
    template<class T>
    using Array = std::vector<T, FreshMemory<T>>;

    Array<SiteRegion> regions; // of faces, then edges, then vertices
    Array<FaceSite> faces;
    Array<EdgeSite> edges;
    Array<VertexSite> vertices;

    SiteArrays arrays() const {
        return {regions.data(),
                faces.data(),
                edges.data(),
                vertices.data(),
                static_cast<std::int32_t>(faces.size()),
                static_cast<std::int32_t>(edges.size())};
    }
};

/// Towers of all faces, wedges of the edges that bend, cones of the vertices that point.
///
/// mesh, topology  positions in voxels; any mesh, open or not, without triangles of no area
/// source          Bærentzen & Aanæs 2005 for the normals of edges and vertices (of a vertex where
///                 several fans meet, one for each); thesis section 4.2.2 for the regions, where
///                 they are polyhedra of closed oriented meshes; ours follow from what any nearest
///                 point obeys (scan_kernel.inl), so that borders get half cylinders, and edges of
///                 three triangles or more and vertices without a ring of triangles around them get
///                 all that is within the half width
Sites voronoi_sites(const Mesh& mesh, const MeshTopology& topology, double half_width_voxels);

/// Without the library call that std::floor is on old instruction sets.
inline int floor_to_int(float x) {
    const int i = static_cast<int>(x);
    return i - (static_cast<float>(i) > x);
}

/// Calls visit(cell) for every cell of cell_size^3 samples, with its samples from cell_size * cell
/// on, within `limits` [cells], that has a sample in the region; it may call for a few more.
template<class Visit>
void for_each_cell(const SiteRegion& region, int cell_size, const IndexBox& limits,
                   const Visit& visit) {
    if (region.low > region.high) return;
    const int k = region.axis;
    const int u = (k + 1) % 3;
    const int v = (k + 2) % 3;
    const float* w = region.direction;
    const auto size = static_cast<float>(cell_size); // a power of two
    const float inverse_size = 1 / size;
    const float inverse_w = 1 / w[k];
    const float reach = region.lateral + region.lateral_slope * std::max(-region.low, region.high);
    const auto cells = [&](int axis, float low, float high, float lateral) {
        const float shift_low = std::min(low * w[axis], high * w[axis]);
        const float shift_high = std::max(low * w[axis], high * w[axis]);
        const float aside = lateral * region.lateral_factor[axis];
        // The last sample of a cell is size - 1 beyond its first.
        const int first =
            -floor_to_int(-(region.base_min[axis] + shift_low - aside - (size - 1)) * inverse_size);
        const int last = floor_to_int((region.base_max[axis] + shift_high + aside) * inverse_size);
        return std::pair(std::max(first, limits.lo[axis]), std::min(last, limits.hi[axis] - 1));
    };
    const auto [k_first, k_last] = cells(k, region.low, region.high, reach);
    const float aside = reach * region.lateral_factor[k];
    Index3 cell;
    for (cell[k] = k_first; cell[k] <= k_last; ++cell[k]) {
        const float first_sample = size * static_cast<float>(cell[k]);
        const float low =
            std::max(region.low, (first_sample - region.base_max[k] - aside) * inverse_w);
        const float high = std::min(
            region.high, (first_sample + size - 1 - region.base_min[k] + aside) * inverse_w);
        if (!(low <= high)) continue;
        const float lateral = region.lateral + region.lateral_slope * std::max(-low, high);
        const auto [u_first, u_last] = cells(u, low, high, lateral);
        const auto [v_first, v_last] = cells(v, low, high, lateral);
        for (cell[v] = v_first; cell[v] <= v_last; ++cell[v])
            for (cell[u] = u_first; cell[u] <= u_last; ++cell[u]) visit(cell);
    }
}

} // namespace isocast
