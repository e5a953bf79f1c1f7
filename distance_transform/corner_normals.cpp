// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/corner_normals.h"

#include <cmath>
#include <numbers>
#include <numeric>

namespace isocast {

namespace {

/// Corners in groups, each named by one of its own.
class Groups {
public:
    explicit Groups(std::size_t count) : parent_(count) {
        std::iota(parent_.begin(), parent_.end(), 0U);
    }
    std::uint32_t of(std::uint32_t corner) {
        while (parent_[corner] != corner)
            corner = parent_[corner] = parent_[parent_[corner]]; // halves the way
        return corner;
    }
    void join(std::uint32_t a, std::uint32_t b) { parent_[of(a)] = of(b); }

private:
    std::vector<std::uint32_t> parent_;
};

std::uint32_t next(std::uint32_t corner) {
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

} // namespace

std::vector<Eigen::Vector3f> corner_normals(const Mesh& mesh, const MeshTopology& topology,
                                            double crease_degrees) {
    std::vector<Vec3d> of_face(mesh.triangles.size());
    for (std::size_t t = 0; t < of_face.size(); ++t)
        of_face[t] = face_normal(mesh, static_cast<int>(t));
    Groups groups(3 * of_face.size());
    const double crease = crease_degrees * std::numbers::pi / 180;
    for (std::size_t e = 0; e < topology.edge_count(); ++e) {
        const auto halfedges = topology.edge(e);
        if (halfedges.size() != 2) continue;
        const std::uint32_t a = halfedges[0];
        const std::uint32_t b = halfedges[1];
        if (halfedge_from(mesh, a) != halfedge_to(mesh, b)) continue;
        if (!(angle_between(of_face[a / 3], of_face[b / 3]) < crease)) continue;
        groups.join(a, next(b));
        groups.join(next(a), b);
    }
    std::vector<Vec3d> sums(3 * of_face.size(), Vec3d::Zero());
    for (std::uint32_t corner = 0; corner < sums.size(); ++corner) {
        const auto vertex = [&](std::uint32_t of) {
            return mesh.vertices_world[static_cast<std::size_t>(halfedge_from(mesh, of))];
        };
        const Vec3d u = vertex(next(corner)) - vertex(corner);
        const Vec3d v = vertex(next(next(corner))) - vertex(corner);
        sums[groups.of(corner)] += angle_between(u, v) * of_face[corner / 3];
    }
    std::vector<Eigen::Vector3f> normals(sums.size());
    for (std::uint32_t corner = 0; corner < sums.size(); ++corner) {
        const Vec3d& sum = sums[groups.of(corner)];
        // A ring that turns all the way over has no mean.
        normals[corner] =
            (sum.norm() > 1e-6 ? sum.normalized() : of_face[corner / 3]).cast<float>();
    }
    return normals;
}

} // namespace isocast
