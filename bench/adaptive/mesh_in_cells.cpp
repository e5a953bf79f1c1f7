// A mesh measured in an octree's finest cells, and which of these it meets, by brute force.
// SPDX-License-Identifier: MPL-2.0
#include "bench/adaptive/mesh_in_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace isocast {

Mesh mesh_in_cells(const Mesh& mesh, int depth, double margin_cells) {
    const WorldBox box = bounding_box(mesh);
    const double across = 1 << depth;
    const double scale = (across - 2 * margin_cells) / box.size().maxCoeff();
    const Vec3d middle = (box.min + box.max) / 2;
    Mesh placed = mesh;
    for (Vec3d& p : placed.vertices_world) p = (scale * (p - middle).array() + across / 2).matrix();
    return placed;
}

void add_mesh(const Mesh& part, Mesh& whole) {
    const auto first = static_cast<int>(whole.vertices_world.size());
    whole.vertices_world.insert(whole.vertices_world.end(), part.vertices_world.begin(),
                                part.vertices_world.end());
    for (const auto& [a, b, c] : part.triangles)
        whole.triangles.push_back({first + a, first + b, first + c});
}

std::vector<Mesh> needles_in_cells(int depth, double thickness, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    const auto random_vector = [&] {
        const double x = any(random);
        const double y = any(random);
        return Vec3d(x, y, any(random));
    };
    const double across = 1 << depth;
    const double length = 30 * thickness;
    const double room = std::max(length + 4, across / 6); // each has a cube of it
    std::vector<Mesh> needles;
    for (double z = room; z + room < across; z += room)
        for (double y = room; y + room < across; y += room)
            for (double x = room; x + room < across; x += room) {
                const Vec3d along = random_vector().normalized();
                const Vec3d side = along.unitOrthogonal();
                const Vec3d middle = Vec3d(x, y, z) + random_vector();
                Mesh needle;
                needle.vertices_world.push_back(middle + length / 2 * along);
                // An equilateral base whose heights are the thickness.
                for (int k = 0; k < 3; ++k)
                    needle.vertices_world.push_back(
                        middle - length / 2 * along +
                        2.0 / 3 * thickness *
                            (Eigen::AngleAxisd(k * 2 * std::numbers::pi / 3, along) * side));
                needle.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
                needles.push_back(needle);
            }
    return needles;
}

bool meet(const std::array<Vec3d, 3>& triangle, const Cube& cube) {
    const std::array<Vec3d, 3> corners = {triangle[0] - cube.centre, triangle[1] - cube.centre,
                                          triangle[2] - cube.centre};
    const auto separates = [&](const Vec3d& axis) {
        const auto [least, greatest] =
            std::minmax({corners[0].dot(axis), corners[1].dot(axis), corners[2].dot(axis)});
        const double reach = cube.half_edge * axis.cwiseAbs().sum();
        return least > reach || greatest < -reach;
    };
    if (separates((corners[1] - corners[0]).cross(corners[2] - corners[0]))) return false;
    for (int i = 0; i < 3; ++i) {
        const Vec3d along = Vec3d::Unit(i);
        if (separates(along)) return false;
        for (std::size_t k = 0; k < 3; ++k)
            if (separates(along.cross(corners[(k + 1) % 3] - corners[k]))) return false;
    }
    return true;
}

std::size_t CellSet::count() const {
    return static_cast<std::size_t>(std::ranges::count(is_in_, true));
}

CellSet surface_cells(const Mesh& mesh, int depth, double grown_by) {
    CellSet cells(depth);
    const Index3 last = Index3::Constant(cells.across() - 1);
    for (const auto& [a, b, c] : mesh.triangles) {
        const std::array<Vec3d, 3> triangle = {mesh.vertices_world[a], mesh.vertices_world[b],
                                               mesh.vertices_world[c]};
        // A cell more on each side: the test decides, not the rounding of the box.
        const auto first_in = [&](const Vec3d& p) -> Index3 {
            return (p.array().floor().cast<int>() - 1).matrix().cwiseMax(0).cwiseMin(last);
        };
        const auto last_in = [&](const Vec3d& p) -> Index3 {
            return (p.array().floor().cast<int>() + 1).matrix().cwiseMax(0).cwiseMin(last);
        };
        const Index3 lo = first_in(triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]));
        const Index3 hi = last_in(triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]));
        for (int z = lo.z(); z <= hi.z(); ++z)
            for (int y = lo.y(); y <= hi.y(); ++y)
                for (int x = lo.x(); x <= hi.x(); ++x) {
                    const Vec3d centre(x + 0.5, y + 0.5, z + 0.5);
                    if (!cells.contains({x, y, z}) && meet(triangle, {centre, 0.5 + grown_by}))
                        cells.insert({x, y, z});
                }
    }
    return cells;
}

} // namespace isocast
