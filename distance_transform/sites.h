// The Voronoi sites of a mesh: its faces, edges and vertices, and where each can be nearest.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh_topology.h"
#include "distance_transform/scan_kernel.h"

namespace isocast {

/// Towers of all faces, wedges of the edges that bend, cones of the vertices that point: what the
/// scan kernels need to make them. The faces are numbered by triangle, then the edges by edge of
/// the topology, then the vertices by fan.
///
/// source  Bærentzen & Aanæs 2005 for the normals of edges and vertices (of a vertex where several
///         fans meet, one for each); thesis section 4.2.2 for the regions, where they are polyhedra
///         of closed oriented meshes; ours follow from what any nearest point obeys
///         (scan_kernel.inl), so that borders get half cylinders, and edges of three triangles or
///         more and vertices without a ring of triangles around them get all that is within the
///         half width
class Sites {
public:
    /// mesh, topology  positions in voxels; any mesh, open or not, without triangles of no area;
    ///                 they must outlive the sites
    Sites(const Mesh& mesh, const MeshTopology& topology, double half_width_voxels,
          InstructionSet instruction_set = best_instruction_set());

    const SiteArrays& arrays() const { return arrays_; }
    const ScanKernels& kernels() const { return kernels_; }
    std::int32_t count() const {
        return arrays_.face_count + arrays_.edge_count + arrays_.fan_count;
    }

    /// The point of a site that is nearest to a sample in its region.
    Vec3d nearest_point(std::int32_t site, const Vec3d& p) const;
    /// The number of a site among features: that of faces and edges, and for all fans of a vertex
    /// one behind these.
    std::int32_t feature(std::int32_t site) const;

private:
    void find_edges(const Mesh& mesh, const MeshTopology& topology);
    void narrow_fans(const Mesh& mesh, const MeshTopology& topology);

    const ScanKernels& kernels_;
    std::vector<FaceNormal> faces_;
    std::vector<EdgeData> edges_;
    std::vector<Vec3d> junctions_;
    std::vector<FanData> fans_;
    SiteArrays arrays_{};
};

} // namespace isocast
