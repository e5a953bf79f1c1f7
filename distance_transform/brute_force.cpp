// The oracle: every triangle against every point, by textbook formulas of its own.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/brute_force.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace isocast {

namespace {

double squared_distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
    const double squared_length = (b - a).squaredNorm();
    const double t =
        squared_length > 0 ? std::clamp((p - a).dot(b - a) / squared_length, 0.0, 1.0) : 0.0;
    return (p - (a + t * (b - a))).squaredNorm();
}

/// The least over the three edges and, where the perpendicular foot of `p` has three positive
/// barycentric coordinates, the plane.
double squared_distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b,
                                    const Vec3d& c) {
    double least =
        std::min({squared_distance_to_segment(p, a, b), squared_distance_to_segment(p, b, c),
                  squared_distance_to_segment(p, c, a)});
    const Vec3d u = b - a;
    const Vec3d v = c - a;
    const Vec3d w = p - a;
    const Vec3d n = u.cross(v);
    const double squared_area = n.squaredNorm();
    const double weight_c = u.cross(w).dot(n);
    const double weight_b = w.cross(v).dot(n);
    if (weight_b > 0 && weight_c > 0 && weight_b + weight_c < squared_area) {
        const double height = w.dot(n);
        least = std::min(least, height * height / squared_area);
    }
    return least;
}

} // namespace

double brute_force_distance(const Mesh& mesh, const Vec3d& p_world) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [ia, ib, ic] : mesh.triangles) {
        const Vec3d& a = mesh.vertices_world[ia];
        const Vec3d& b = mesh.vertices_world[ib];
        const Vec3d& c = mesh.vertices_world[ic];
        // The triangle lies in the sphere about `a` of radius r, so that it is farther than d if
        // |p - a| > d + r; and (d + r)^2 <= 2 (d^2 + r^2) saves the roots.
        const double squared_radius = std::max((b - a).squaredNorm(), (c - a).squaredNorm());
        if ((p_world - a).squaredNorm() > 2 * (least + squared_radius)) continue;
        least = std::min(least, squared_distance_to_triangle(p_world, a, b, c));
    }
    return std::sqrt(least);
}

double brute_force_winding_number(const Mesh& mesh, const Vec3d& p_world) {
    double half_solid_angle = 0;
    for (const auto& [ia, ib, ic] : mesh.triangles) {
        const Vec3d a = mesh.vertices_world[ia] - p_world;
        const Vec3d b = mesh.vertices_world[ib] - p_world;
        const Vec3d c = mesh.vertices_world[ic] - p_world;
        const double la = a.norm();
        const double lb = b.norm();
        const double lc = c.norm();
        half_solid_angle += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc +
                                                              b.dot(c) * la + c.dot(a) * lb);
    }
    return half_solid_angle / (2 * std::numbers::pi);
}

} // namespace isocast
