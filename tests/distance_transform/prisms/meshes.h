// Meshes with properties that the thesis's polyhedra care about.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "cgal_oracle.h"
#include "distance_transform/mesh.h"

#include <CGAL/convex_hull_3.h>

#include <cmath>
#include <numbers>
#include <random>

namespace isocast::test {

inline Vec3d random_unit(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return Vec3d(normal(random), normal(random), normal(random)).normalized();
}

/// The cube [-1, 1]^3; each face two coplanar triangles.
inline Mesh cube() {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices_world.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

/// Convex hull of `count` random points on an ellipsoid of random axes.
inline Mesh random_hull(int count, std::mt19937& random) {
    std::uniform_real_distribution<double> axis(0.3, 1);
    const Vec3d axes(axis(random), axis(random), axis(random));
    std::vector<CgalKernel::Point_3> points;
    for (int i = 0; i < count; ++i) {
        const Vec3d p = random_unit(random).cwiseProduct(axes);
        points.emplace_back(p.x(), p.y(), p.z());
    }
    CgalMesh hull;
    CGAL::convex_hull_3(points.begin(), points.end(), hull);
    Mesh mesh;
    for (const auto vertex : hull.vertices()) {
        const auto& p = hull.point(vertex);
        mesh.vertices_world.emplace_back(p.x(), p.y(), p.z());
    }
    for (const auto face : hull.faces()) {
        std::array<int, 3> triangle;
        auto halfedge = hull.halfedge(face);
        for (int& vertex : triangle) {
            vertex = static_cast<int>(hull.target(halfedge).idx());
            halfedge = hull.next(halfedge);
        }
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

/// A hull with each vertex moved along its ray from the middle: spikes and saddles, still a
/// star-shaped solid.
inline Mesh random_spiky_solid(int count, std::mt19937& random) {
    std::uniform_real_distribution<double> factor(0.5, 1.5);
    Mesh mesh = random_hull(count, random);
    for (Vec3d& p : mesh.vertices_world) p *= factor(random);
    return mesh;
}

/// A solid whose vertex 0, at the origin, is a saddle of valence 8 as in figure 4.5, and leaves a
/// gap. Its neighbours go up and down by turns; each way up is wide and each way down narrow, so
/// that at ridges and valleys alike the bisector planes lean to the same side. The z axis is then
/// right of all of them, or left.
inline Mesh saddle_of_eight() {
    Mesh mesh;
    mesh.vertices_world.push_back(Vec3d::Zero());
    const auto ring_point = [](int i, double radius, double z) {
        const double degrees = 90.0 * (i / 2) + (i % 2 == 0 ? 0 : 65);
        const double angle = degrees * std::numbers::pi / 180;
        return Vec3d(radius * std::cos(angle), radius * std::sin(angle), z);
    };
    for (int i = 0; i < 8; ++i)
        mesh.vertices_world.push_back(ring_point(i, 1, i % 2 == 0 ? -0.3 : 0.3));
    for (int i = 0; i < 8; ++i) mesh.vertices_world.push_back(ring_point(i, 1, -2));
    const int bottom = static_cast<int>(mesh.vertices_world.size());
    mesh.vertices_world.emplace_back(0, 0, -2);
    for (int i = 0; i < 8; ++i) {
        const int next = (i + 1) % 8;
        mesh.triangles.push_back({0, 1 + i, 1 + next});
        mesh.triangles.push_back({1 + i, 9 + i, 9 + next});
        mesh.triangles.push_back({1 + i, 9 + next, 1 + next});
        mesh.triangles.push_back({bottom, 9 + next, 9 + i});
    }
    return mesh;
}

} // namespace isocast::test
