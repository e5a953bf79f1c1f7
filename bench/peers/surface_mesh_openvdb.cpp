// The surface by OpenVDB's volumeToMesh.
// SPDX-License-Identifier: MPL-2.0
#include "peers/peer_frame.h"
#include "peers/surface_mesh.h"
#include "volume/vdb_grid.h"

#include <openvdb/tools/VolumeToMesh.h>

namespace isocast {

SurfaceMesh extract_surface(const SparseField& field) {
    const openvdb::FloatGrid::Ptr grid = to_vdb_grid(field);
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec4I> quads;
    const auto start = std::chrono::steady_clock::now();
    openvdb::tools::volumeToMesh(*grid, points, quads);
    SurfaceMesh mesh{.extraction_seconds = seconds_since(start), .extractor = "volumeToMesh"};

    for (const openvdb::Vec3s& p : points) mesh.points_world.emplace_back(p.x(), p.y(), p.z());
    for (const openvdb::Vec4I& q : quads) {
        mesh.triangles.push_back({q[0], q[1], q[2]});
        mesh.triangles.push_back({q[0], q[2], q[3]});
    }
    mesh.normals.assign(points.size(), Eigen::Vector3f::Zero());
    for (const auto& [a, b, c] : mesh.triangles) {
        const auto& p = mesh.points_world;
        const Eigen::Vector3f weighted_by_area = (p[b] - p[a]).cross(p[c] - p[a]);
        for (const std::uint32_t corner : {a, b, c}) mesh.normals[corner] += weighted_by_area;
    }
    return mesh;
}

} // namespace isocast
