// Meshes that the hard cases are made of.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/sample_meshes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace isocast::test {

using Triangle = std::array<int, 3>;

template<class Map>
Mesh mapped(Mesh mesh, const Map& map) {
    for (Vec3d& p : mesh.vertices_world) p = map(p);
    return mesh;
}

inline Mesh turned_round(Mesh mesh) {
    for (Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    return mesh;
}

inline Mesh joined(Mesh mesh, const Mesh& other) {
    const int first = static_cast<int>(mesh.vertices_world.size());
    mesh.vertices_world.insert(mesh.vertices_world.end(), other.vertices_world.begin(),
                               other.vertices_world.end());
    for (const auto& [a, b, c] : other.triangles)
        mesh.triangles.push_back({a + first, b + first, c + first});
    return mesh;
}

inline Mesh moved(const Mesh& mesh, const Vec3d& by) {
    return mapped(mesh, [&](const Vec3d& p) { return Vec3d(p + by); });
}

inline Mesh scaled(const Mesh& mesh, double factor) {
    return mapped(mesh, [&](const Vec3d& p) { return Vec3d(factor * p); });
}

/// Positions rounded to multiples of 2^-20, so that differences and moves by them are exact.
inline Mesh rounded(const Mesh& mesh) {
    return mapped(mesh,
                  [](const Vec3d& p) { return Vec3d((p * 0x1p20).array().round() * 0x1p-20); });
}

/// A rotation that aligns nothing with the lattice.
inline Mesh tilted(const Mesh& mesh) {
    const Mat3d rotation =
        Eigen::AngleAxisd(0.7, Vec3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
    return mapped(mesh, [&](const Vec3d& p) { return Vec3d(rotation * p); });
}

/// Every triangle cut into four at the middles of its edges, `times` over.
inline Mesh subdivided(Mesh mesh, int times) {
    for (; times > 0; --times) mesh = isocast::subdivided(mesh);
    return mesh;
}

/// Unit sphere of 8 * 4^times triangles.
inline Mesh sphere(int times) {
    return mapped(subdivided(octahedron(), times), [](const Vec3d& p) { return p.normalized(); });
}

/// The box between `lo` and `hi`, 12 triangles.
inline Mesh box(const Vec3d& lo, const Vec3d& hi) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices_world.emplace_back(i & 1 ? hi.x() : lo.x(), i & 2 ? hi.y() : lo.y(),
                                         i & 4 ? hi.z() : lo.z());
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

/// [-1, 1]^3.
inline Mesh cube() {
    return box(-Vec3d::Ones(), Vec3d::Ones());
}

inline Mesh tetrahedron() {
    return {{Vec3d(1, 1, 1), Vec3d(1, -1, -1), Vec3d(-1, 1, -1), Vec3d(-1, -1, 1)},
            {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
}

/// Two cones over one closed line of corners, to the apex `top` and to `bottom`. The line turns
/// counter-clockwise seen from the top.
inline Mesh double_cone(const std::vector<Vec3d>& line, const Vec3d& top, const Vec3d& bottom) {
    Mesh mesh{line, {}};
    const int n = static_cast<int>(line.size());
    mesh.vertices_world.push_back(top);
    mesh.vertices_world.push_back(bottom);
    for (int i = 0; i < n; ++i) {
        const int next = (i + 1) % n;
        mesh.triangles.insert(mesh.triangles.end(), {{i, next, n}, {next, i, n + 1}});
    }
    return mesh;
}

/// A closed tube of round cross section about the closed curve `centre(t)`, t in [0, 2 pi).
template<class Curve>
Mesh tube(const Curve& centre, double radius, int rings, int sides) {
    using std::numbers::pi;
    Mesh mesh;
    for (int i = 0; i < rings; ++i) {
        const double t = 2 * pi * i / rings;
        const Vec3d tangent = (centre(t + 1e-4) - centre(t - 1e-4)).normalized();
        // Of a curve that never runs along z.
        const Vec3d u = Vec3d::UnitZ().cross(tangent).normalized();
        const Vec3d v = tangent.cross(u);
        for (int k = 0; k < sides; ++k) {
            const double angle = 2 * pi * k / sides;
            mesh.vertices_world.emplace_back(centre(t) +
                                             radius * (std::cos(angle) * u + std::sin(angle) * v));
        }
    }
    for (int i = 0; i < rings; ++i) {
        for (int k = 0; k < sides; ++k) {
            const int a = i * sides + k;
            const int b = i * sides + (k + 1) % sides;
            const int c = (i + 1) % rings * sides + k;
            const int d = (i + 1) % rings * sides + (k + 1) % sides;
            mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {b, d, c}});
        }
    }
    return mesh;
}

/// A sphere drawn out along each vertex by smooth waves and by noise of its own: star-shaped, so
/// that it is closed and free of self-intersections.
inline Mesh noisy_sphere(unsigned seed, int times) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    Mesh mesh = sphere(times);
    std::vector<std::pair<Vec3d, double>> waves;
    for (int i = 0; i < 4; ++i) {
        const double x = 8 * unit(random) - 4;
        const double y = 8 * unit(random) - 4;
        waves.emplace_back(Vec3d(x, y, 8 * unit(random) - 4), 6 * unit(random));
    }
    const double roughness = 0.4 * unit(random);
    for (Vec3d& p : mesh.vertices_world) {
        double radius = 1 + roughness * (unit(random) - 0.5);
        for (const auto& [direction, phase] : waves)
            radius += 0.12 * std::sin(direction.dot(p) + phase);
        p *= radius;
    }
    return mesh;
}

} // namespace isocast::test
