// Distance and winding number of any triangle soup by CGAL, for large meshes. Tests only (GPL).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <cmath>
#include <random>

namespace isocast::test {

class SoupOracle {
public:
    explicit SoupOracle(const Mesh& mesh) {
        for (const auto& [a, b, c] : mesh.triangles) {
            const Kernel::Triangle_3 triangle(point(mesh.vertices_world[a]),
                                              point(mesh.vertices_world[b]),
                                              point(mesh.vertices_world[c]));
            if (!triangle.is_degenerate()) triangles_.push_back(triangle);
        }
        tree_.insert(triangles_.begin(), triangles_.end());
        tree_.build();
        tree_.accelerate_distance_queries();
    }
    SoupOracle(const SoupOracle&) = delete;
    SoupOracle& operator=(const SoupOracle&) = delete;

    double distance(const Vec3d& p) const { return std::sqrt(tree_.squared_distance(point(p))); }

    /// Of a closed oriented surface: how often a ray leaves it, less how often it enters, by exact
    /// predicates. Rays through edges or along planes are drawn again.
    int winding_number(const Vec3d& p) const {
        std::mt19937 random(1);
        std::uniform_real_distribution<double> unit(-1, 1);
        for (;;) {
            const double x = unit(random);
            const double y = unit(random);
            const Kernel::Point_3 from = point(p);
            const Kernel::Point_3 to = point(p + Vec3d(x, y, unit(random)));
            std::vector<Primitive::Id> hits;
            tree_.all_intersected_primitives(Kernel::Ray_3(from, to), std::back_inserter(hits));
            int sum = 0;
            bool is_generic = true;
            for (const Primitive::Id& hit : hits) {
                const Kernel::Triangle_3& t = *hit;
                for (int k = 0; k < 3; ++k)
                    is_generic =
                        is_generic && CGAL::orientation(from, to, t[k], t[k + 1]) != CGAL::COPLANAR;
                const CGAL::Orientation side = CGAL::orientation(t[0], t[1], t[2], from);
                is_generic = is_generic && side != CGAL::COPLANAR;
                sum += side == CGAL::NEGATIVE ? 1 : -1;
            }
            if (is_generic) return sum;
        }
    }

private:
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Primitive =
        CGAL::AABB_triangle_primitive<Kernel, std::vector<Kernel::Triangle_3>::const_iterator>;

    static Kernel::Point_3 point(const Vec3d& p) { return {p.x(), p.y(), p.z()}; }

    std::vector<Kernel::Triangle_3> triangles_;
    CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree_;
};

} // namespace isocast::test
