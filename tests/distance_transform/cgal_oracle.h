// Distance and side of a closed mesh by CGAL: search tree and exact predicates. Tests only (GPL).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

#include <cmath>
#include <stdexcept>

namespace isocast::test {

using CgalKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalMesh = CGAL::Surface_mesh<CgalKernel::Point_3>;

inline CgalMesh cgal_mesh(const Mesh& mesh) {
    CgalMesh result;
    for (const Vec3d& p : mesh.vertices_world)
        result.add_vertex(CgalKernel::Point_3(p.x(), p.y(), p.z()));
    using Vertex = CgalMesh::Vertex_index;
    for (const auto& [a, b, c] : mesh.triangles) {
        const auto face =
            result.add_face(Vertex(static_cast<unsigned>(a)), Vertex(static_cast<unsigned>(b)),
                            Vertex(static_cast<unsigned>(c)));
        if (face == CgalMesh::null_face())
            throw std::invalid_argument("CGAL's Surface_mesh holds manifold meshes only");
    }
    return result;
}

class CgalOracle {
public:
    explicit CgalOracle(const Mesh& mesh)
        : mesh_(cgal_mesh(mesh)), tree_(faces(mesh_).first, faces(mesh_).second, mesh_),
          side_(tree_) {
        tree_.accelerate_distance_queries();
    }
    CgalOracle(const CgalOracle&) = delete;
    CgalOracle& operator=(const CgalOracle&) = delete;

    bool is_inside(const Vec3d& p) const {
        return side_(CgalKernel::Point_3(p.x(), p.y(), p.z())) == CGAL::ON_BOUNDED_SIDE;
    }
    double distance(const Vec3d& p) const {
        return std::sqrt(tree_.squared_distance(CgalKernel::Point_3(p.x(), p.y(), p.z())));
    }
    double signed_distance(const Vec3d& p) const {
        return is_inside(p) ? -distance(p) : distance(p);
    }

private:
    using Primitive = CGAL::AABB_face_graph_triangle_primitive<CgalMesh>;
    using Tree = CGAL::AABB_tree<CGAL::AABB_traits<CgalKernel, Primitive>>;
    CgalMesh mesh_;
    Tree tree_;
    CGAL::Side_of_triangle_mesh<CgalMesh, CgalKernel, CGAL::Default, Tree> side_;
};

} // namespace isocast::test
