// What the tests of adaptive fields share: meshes in finest cells, fields by formula, trees built.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../../volume/random_fields.h"
#include "../fields.h"
#include "bench/adaptive/mesh_in_cells.h"
#include "distance_transform/adaptive.h"
#include "distance_transform/mesh_distance.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"

namespace isocast::test {

inline constexpr std::array octree_filters = {OctreeFilter::Linear, OctreeFilter::Cubic};

/// A mesh in finest cells with its distance.
class MeshInCells {
public:
    explicit MeshInCells(const Mesh& mesh_in_cells)
        : mesh_(check(mesh_in_cells)), distance_(mesh_.mesh, mesh_.topology, nullptr) {}
    MeshInCells(const MeshInCells&) = delete;
    MeshInCells& operator=(const MeshInCells&) = delete;
    const Mesh& mesh() const { return mesh_.mesh; }
    const MeshDistance& distance() const { return distance_; }

private:
    CheckedMesh mesh_;
    MeshDistance distance_;
};

inline Mesh moved(Mesh mesh, double scale, const Vec3d& to) {
    for (Vec3d& p : mesh.vertices_world) p = scale * p + to;
    return mesh;
}

inline ExactDistance::Sample sphere_distance(const Vec3d& p, const Vec3d& centre, double radius) {
    const Vec3d offset = p - centre;
    return {offset.norm() - radius,
            offset.norm() > 0 ? Vec3d(offset.normalized()) : Vec3d(Vec3d::UnitX())};
}

/// Points of triangles, as many of each whatever its area, and corners in turn.
inline std::vector<Vec3d> points_of_surface(const Mesh& mesh, int count, Random& random) {
    std::vector<Vec3d> points;
    for (int i = 0; i < count; ++i) {
        const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(i) % mesh.triangles.size()];
        double u = random_real(random, 0, 1);
        double v = random_real(random, 0, 1);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const Vec3d& origin = mesh.vertices_world[a];
        points.push_back(origin + u * (mesh.vertices_world[b] - origin) +
                         v * (mesh.vertices_world[c] - origin));
    }
    points.insert(points.end(), mesh.vertices_world.begin(), mesh.vertices_world.end());
    return points;
}

/// Cells, links and data, in the order in which the tree keeps and visits them.
struct TreeContent {
    explicit TreeContent(const HashedOctree& tree) {
        tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
            const Index3& p = cell.position;
            const HashedOctree::CellNumber number = tree.find(cell).value();
            cells.push_back(
                {p.x(), p.y(), p.z(), cell.level, is_leaf ? 1 : 0, static_cast<int>(number)});
            links.push_back(tree.nodes_of(number));
        });
        for (HashedOctree::NodeNumber node = 0; node < tree.node_count(); ++node) {
            const auto values = tree.data_of(node);
            data.insert(data.end(), values.begin(), values.end());
            constrained.push_back(tree.is_constrained(node));
        }
    }
    bool operator==(const TreeContent&) const = default;

    std::vector<std::array<int, 6>> cells;
    std::vector<std::array<HashedOctree::NodeNumber, 8>> links;
    std::vector<float> data;
    std::vector<bool> constrained;
};

} // namespace isocast::test
