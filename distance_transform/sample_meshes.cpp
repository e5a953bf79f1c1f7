// Built-in meshes: a subdivided sphere, and tubes around a circle, a trefoil and a spiral.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/sample_meshes.h"

#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace isocast {

namespace {

constexpr double two_pi = 2 * std::numbers::pi;

/// One cross section of a tube: the circle centre + radius (cos phi u + sin phi v), with u x v
/// along the tube.
struct Section {
    Vec3d centre;
    Vec3d u;
    Vec3d v;
    double radius;
};

/// Joins consecutive sections by quads cut into triangles; the last to the first if closed.
Mesh tube(const std::vector<Section>& sections, int sides, bool is_closed) {
    Mesh mesh;
    for (const Section& section : sections) {
        for (int k = 0; k < sides; ++k) {
            const double phi = two_pi * k / sides;
            mesh.vertices_world.push_back(
                section.centre +
                section.radius * (std::cos(phi) * section.u + std::sin(phi) * section.v));
        }
    }
    const int count = static_cast<int>(sections.size());
    for (int i = 0; i < (is_closed ? count : count - 1); ++i) {
        const int next = (i + 1) % count;
        for (int k = 0; k < sides; ++k) {
            const int a = i * sides + k;
            const int b = i * sides + (k + 1) % sides;
            const int c = next * sides + (k + 1) % sides;
            const int d = next * sides + k;
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
        }
    }
    return mesh;
}

/// 60 sections of 50 vertices, radii 1 and 0.4.
Mesh torus() {
    std::vector<Section> sections;
    for (int i = 0; i < 60; ++i) {
        const double theta = two_pi * i / 60;
        const Vec3d outward(std::cos(theta), std::sin(theta), 0);
        sections.push_back({outward, Vec3d::UnitZ(), outward, 0.4});
    }
    return tube(sections, 50, true);
}

/// 120 sections of 12 vertices along the trefoil (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t), in
/// its Frenet frames, which close since its curvature never vanishes.
Mesh knot() {
    std::vector<Section> sections;
    for (int i = 0; i < 120; ++i) {
        const double t = two_pi * i / 120;
        const Vec3d centre(std::sin(t) + 2 * std::sin(2 * t), std::cos(t) - 2 * std::cos(2 * t),
                           -std::sin(3 * t));
        const Vec3d first(std::cos(t) + 4 * std::cos(2 * t), -std::sin(t) + 4 * std::sin(2 * t),
                          -3 * std::cos(3 * t));
        const Vec3d second(-std::sin(t) - 8 * std::sin(2 * t), -std::cos(t) + 8 * std::cos(2 * t),
                           9 * std::sin(3 * t));
        const Vec3d binormal = first.cross(second).normalized();
        sections.push_back({centre, binormal.cross(first).normalized(), binormal, 0.45});
    }
    return tube(sections, 12, true);
}

/// Four turns of a tube around a logarithmic spiral, 83 sections of 11 vertices, and a flat cap
/// with a vertex in its middle at each end: 915 vertices.
///
/// All sections are circles in half-planes through the axis, so that the tube meets itself only if
/// two circles one turn apart do. A turn scales by g = 1.9: centres (1, -1.5) and g (1, -1.5) are
/// 0.9 sqrt(3.25) = 1.62 apart, the radii 0.45 (1 + g) = 1.31 together.
Mesh seashell() {
    constexpr int count = 83;
    constexpr int sides = 11;
    constexpr double turns = 4;
    std::vector<Section> sections;
    for (int i = 0; i < count; ++i) {
        const double turn = turns * i / (count - 1);
        const double scale = std::pow(1.9, turn - turns);
        const double theta = two_pi * turn;
        const Vec3d outward(std::cos(theta), std::sin(theta), 0);
        sections.push_back(
            {scale * (outward - 1.5 * Vec3d::UnitZ()), Vec3d::UnitZ(), outward, 0.45 * scale});
    }
    Mesh mesh = tube(sections, sides, false);
    const int start = static_cast<int>(mesh.vertices_world.size());
    const int end = start + 1;
    const int last_section = (count - 1) * sides;
    mesh.vertices_world.push_back(sections.front().centre);
    mesh.vertices_world.push_back(sections.back().centre);
    for (int k = 0; k < sides; ++k) {
        const int next = (k + 1) % sides;
        mesh.triangles.push_back({start, next, k});
        mesh.triangles.push_back({end, last_section + k, last_section + next});
    }
    return mesh;
}

struct SampleMesh {
    std::string_view name;
    Mesh (*make)();
};

constexpr std::array samples = {SampleMesh{"sphere6", [] { return subdivided_sphere(6); }},
                                SampleMesh{"torus", torus}, SampleMesh{"knot", knot},
                                SampleMesh{"seashell", seashell}};

} // namespace

Mesh subdivided(const Mesh& mesh) {
    Mesh finer{mesh.vertices_world, {}};
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
        const auto [found, is_new] =
            middles.try_emplace(std::minmax(a, b), static_cast<int>(finer.vertices_world.size()));
        if (is_new)
            finer.vertices_world.emplace_back((mesh.vertices_world[a] + mesh.vertices_world[b]) /
                                              2);
        return found->second;
    };
    for (const auto& [a, b, c] : mesh.triangles) {
        const int ab = middle(a, b);
        const int bc = middle(b, c);
        const int ca = middle(c, a);
        finer.triangles.insert(finer.triangles.end(),
                               {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    return finer;
}

Mesh octahedron() {
    return {
        {Vec3d::UnitX(), -Vec3d::UnitX(), Vec3d::UnitY(), -Vec3d::UnitY(), Vec3d::UnitZ(),
         -Vec3d::UnitZ()},
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

Mesh subdivided_sphere(int levels) {
    Mesh mesh = octahedron();
    for (int level = 0; level < levels; ++level) {
        const std::size_t before = mesh.vertices_world.size();
        mesh = subdivided(mesh);
        for (std::size_t v = before; v < mesh.vertices_world.size(); ++v)
            mesh.vertices_world[v].normalize();
    }
    return mesh;
}

std::vector<std::string> sample_mesh_names() {
    std::vector<std::string> names;
    for (const SampleMesh& known : samples) names.emplace_back(known.name);
    return names;
}

Mesh sample_mesh(std::string_view name) {
    for (const SampleMesh& known : samples)
        if (known.name == name) return known.make();
    throw InputError(fmt::format("unknown sample mesh '{}' (known: {})", name,
                                 fmt::join(sample_mesh_names(), ", ")));
}

} // namespace isocast
