// SPDX-License-Identifier: MPL-2.0
#include "stability/shapes.h"

#include "distance_transform/sample_meshes.h"

#include <algorithm>
#include <numbers>
#include <random>

namespace isocast::stability {

using std::numbers::pi;

namespace {

const Vec3d& vertex(const Mesh& mesh, int i) {
    return mesh.vertices_world[static_cast<std::size_t>(i)];
}

int added(Mesh& mesh, const Vec3d& p) {
    mesh.vertices_world.push_back(p);
    return static_cast<int>(mesh.vertices_world.size()) - 1;
}

/// `mesh` with cut(result, triangle) in place of every third triangle.
template<class Cut>
Mesh with_every_third_cut(Mesh mesh, const Cut& cut) {
    const std::vector<Triangle> whole = std::exchange(mesh.triangles, {});
    for (std::size_t t = 0; t < whole.size(); ++t) {
        if (t % 3 != 0)
            mesh.triangles.push_back(whole[t]);
        else
            cut(mesh, whole[t]);
    }
    return mesh;
}

} // namespace

Mesh turned_round(Mesh mesh) {
    for (Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    return mesh;
}

Mesh joined(Mesh mesh, const Mesh& other) {
    const int first = static_cast<int>(mesh.vertices_world.size());
    for (const Vec3d& p : other.vertices_world) mesh.vertices_world.push_back(p);
    for (const auto& [a, b, c] : other.triangles)
        mesh.triangles.push_back({a + first, b + first, c + first});
    return mesh;
}

Mesh rounded(const Mesh& mesh) {
    return mapped(mesh,
                  [](const Vec3d& p) { return Vec3d((p * 0x1p20).array().round() * 0x1p-20); });
}

Mesh tilted(const Mesh& mesh) {
    const Mat3d turn =
        Eigen::AngleAxisd(0.7, Vec3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
    return mapped(mesh, [&](const Vec3d& p) { return Vec3d(turn * p); });
}

Mesh box(const Vec3d& lo, const Vec3d& hi) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices_world.emplace_back(i & 1 ? hi.x() : lo.x(), i & 2 ? hi.y() : lo.y(),
                                         i & 4 ? hi.z() : lo.z());
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

Mesh tetrahedron() {
    return {{Vec3d(1, 1, 1), Vec3d(1, -1, -1), Vec3d(-1, 1, -1), Vec3d(-1, -1, 1)},
            {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
}

Mesh subdivided(Mesh mesh, int times) {
    for (; times > 0; --times) mesh = isocast::subdivided(mesh);
    return mesh;
}

Mesh sphere(int times) {
    return mapped(subdivided(octahedron(), times), [](const Vec3d& p) { return p.normalized(); });
}

Mesh noisy_sphere(unsigned seed, int times) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    std::array<std::pair<Vec3d, double>, 4> waves;
    for (auto& [direction, phase] : waves) {
        const double x = 8 * unit(random) - 4;
        const double y = 8 * unit(random) - 4;
        direction = Vec3d(x, y, 8 * unit(random) - 4);
        phase = 6 * unit(random);
    }
    const double roughness = 0.4 * unit(random);
    return mapped(sphere(times), [&](const Vec3d& p) {
        double radius = 1 + roughness * (unit(random) - 0.5);
        for (const auto& [direction, phase] : waves)
            radius += 0.12 * std::sin(direction.dot(p) + phase);
        return Vec3d(radius * p);
    });
}

Mesh double_cone(const std::vector<Vec3d>& line, const Vec3d& top, const Vec3d& bottom) {
    Mesh mesh{line, {}};
    const int n = static_cast<int>(line.size());
    mesh.vertices_world.push_back(top);
    mesh.vertices_world.push_back(bottom);
    for (int i = 0; i < n; ++i) {
        mesh.triangles.push_back({i, (i + 1) % n, n});
        mesh.triangles.push_back({(i + 1) % n, i, n + 1});
    }
    return mesh;
}

Mesh saddle_cone(int valence) {
    std::vector<Vec3d> rim;
    for (int i = 0; i < valence; ++i)
        rim.emplace_back(std::cos(2 * pi * i / valence), std::sin(2 * pi * i / valence),
                         i % 2 == 0 ? 0.6 : -0.6);
    return tilted(double_cone(rim, Vec3d(0.01, 0.02, 0), Vec3d(0, 0, -1.1)));
}

Mesh with_slivers(Mesh mesh, double height) {
    return with_every_third_cut(std::move(mesh), [&](Mesh& result, const Triangle& triangle) {
        const auto& [a, b, c] = triangle;
        const Vec3d middle = (vertex(result, a) + vertex(result, b)) / 2;
        const double length = (vertex(result, b) - vertex(result, a)).norm();
        const Vec3d inward = (vertex(result, c) - middle).normalized();
        const int m = added(result, middle + height * length * (inward + middle.normalized()));
        result.triangles.insert(result.triangles.end(), {{a, b, m}, {b, c, m}, {c, a, m}});
    });
}

Mesh with_seams(Mesh mesh, double share, bool is_closed) {
    return with_every_third_cut(std::move(mesh), [&](Mesh& result, const Triangle& triangle) {
        const auto& [a, b, c] = triangle;
        const Vec3d along = vertex(result, b) - vertex(result, a);
        const int m = added(result, vertex(result, a) + share * along);
        result.triangles.insert(result.triangles.end(), {{a, m, c}, {m, b, c}});
        if (is_closed) result.triangles.push_back({a, b, m});
    });
}

Mesh unindexed(const Mesh& mesh) {
    Mesh soup;
    for (const auto& [a, b, c] : mesh.triangles) {
        const int first = added(soup, vertex(mesh, a));
        added(soup, vertex(mesh, b));
        added(soup, vertex(mesh, c));
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    return soup;
}

Mesh with_flips(Mesh mesh, int one_in) {
    for (std::size_t t = 1; t < mesh.triangles.size(); t += static_cast<std::size_t>(one_in))
        std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    return mesh;
}

Mesh moebius_strip(int around) {
    Mesh mesh;
    for (int i = 0; i < around; ++i) {
        const double t = 2 * pi * i / around;
        const Vec3d outward(std::cos(t), std::sin(t), 0);
        const Vec3d across = std::cos(t / 2) * outward + std::sin(t / 2) * Vec3d::UnitZ();
        for (const double side : {-0.3, 0.3}) added(mesh, outward + side * across);
    }
    for (int i = 0; i < around; ++i) {
        // After one turn the two sides have changed places.
        const bool is_last = i + 1 == around;
        const int c = is_last ? 1 : 2 * i + 2;
        const int d = is_last ? 0 : 2 * i + 3;
        mesh.triangles.insert(mesh.triangles.end(), {{2 * i, 2 * i + 1, c}, {2 * i + 1, d, c}});
    }
    return mesh;
}

Mesh crossing_tube(int rings, int sides) {
    const auto centre = [](double t) {
        return Vec3d(std::sin(t), 0.6 * std::sin(2 * t), 0.12 * std::cos(t));
    };
    Mesh mesh;
    for (int i = 0; i < rings; ++i) {
        const double t = 2 * pi * i / rings;
        const Vec3d tangent = (centre(t + 1e-4) - centre(t - 1e-4)).normalized();
        const Vec3d u = Vec3d::UnitZ().cross(tangent).normalized();
        const Vec3d v = tangent.cross(u);
        for (int k = 0; k < sides; ++k)
            added(mesh, centre(t) + 0.2 * (std::cos(2 * pi * k / sides) * u +
                                           std::sin(2 * pi * k / sides) * v));
    }
    for (int i = 0; i < rings; ++i)
        for (int k = 0; k < sides; ++k) {
            const int next = (i + 1) % rings * sides, beside = (k + 1) % sides;
            const int a = i * sides + k, b = i * sides + beside;
            mesh.triangles.insert(mesh.triangles.end(),
                                  {{a, b, next + k}, {b, next + beside, next + k}});
        }
    return mesh;
}

Mesh needle_on_a_ball() {
    Mesh mesh = sphere(2);
    // One vertex drawn out: its edges are 45 degrees / 4 apart, so the base must shrink as well.
    const Vec3d tip = mesh.vertices_world[4];
    for (Vec3d& p : mesh.vertices_world) {
        const double angle = std::acos(std::clamp(p.dot(tip), -1.0, 1.0));
        if (angle > 0.01 && angle < 0.5)
            p = (tip + 2e-4 * (p - tip.dot(p) * tip).normalized()).normalized();
    }
    mesh.vertices_world[4] = 2.1 * tip;
    return mesh;
}

Mesh in_voxels(const Mesh& mesh, const GridSpace& space, const Index3& origin) {
    const long double voxel = space.voxel_size_world();
    return mapped(mesh, [&](Vec3d p) {
        for (int k = 0; k < 3; ++k)
            p[k] = static_cast<double>(
                (p[k] - static_cast<long double>(space.world_from_index.translation()[k])) / voxel -
                origin[k]);
        return p;
    });
}

IndexBox box_about(const Mesh& mesh, const GridSpace& space, double half_width_voxels) {
    const WorldBox bounds = bounding_box(in_voxels(mesh, space, Index3::Zero()));
    const int reach = static_cast<int>(half_width_voxels) + 3;
    return {bounds.min.array().floor().cast<int>() - reach,
            bounds.max.array().ceil().cast<int>() + reach + 1};
}

} // namespace isocast::stability
