// SPDX-License-Identifier: MPL-2.0
#include "quadrics/tetrahedra.h"

#include "quadrics/indexed_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace isocast {

namespace {

/// Where an edge's coefficient is kept.
std::size_t place_of(int k, int l) {
    if (k == l) return static_cast<std::size_t>(k);
    const std::array edge{std::min(k, l), std::max(k, l)};
    return 4 + static_cast<std::size_t>(std::ranges::find(tetrahedron_edges, edge) -
                                        tetrahedron_edges.begin());
}

} // namespace

Eigen::Matrix<double, 3, 4> Tetrahedron::barycentric_gradients() const {
    Eigen::Matrix<double, 3, 4> gradients;
    for (std::size_t k = 0; k < 4; ++k) {
        // Across the face of the other three, by the two shorter edges from each of its corners.
        const Vec3d& a = corners_world[(k + 1) % 4];
        const Vec3d& b = corners_world[(k + 2) % 4];
        const Vec3d& c = corners_world[(k + 3) % 4];
        const Vec3d normal = (b - a).cross(c - a);
        gradients.col(static_cast<Eigen::Index>(k)) = normal / normal.dot(corners_world[k] - a);
    }
    return gradients;
}

Tetrahedron tetrahedron_of(const TetrahedralMesh& mesh, std::size_t i) {
    Tetrahedron out;
    for (int k = 0; k < 4; ++k) {
        out.corners_world[static_cast<std::size_t>(k)] =
            mesh.vertices_world[static_cast<std::size_t>(
                mesh.tetrahedra[i][static_cast<std::size_t>(k)])];
        for (int l = 0; l < 4; ++l)
            out.coefficients(k, l) = static_cast<double>(mesh.coefficients[i][place_of(k, l)]);
    }
    return out;
}

void append(TetrahedralMesh& mesh, const std::array<int, 4>& corners,
            const std::array<float, 10>& coefficients) {
    // The function lies between the least and the greatest of its coefficients.
    const auto [least, greatest] = std::ranges::minmax(coefficients);
    if (least > 0 || greatest < 0) return;
    std::array<int, 4> order{0, 1, 2, 3};
    std::ranges::sort(order, {}, [&](int k) { return corners[static_cast<std::size_t>(k)]; });
    std::array<int, 4> sorted{};
    std::array<float, 10> of_sorted{};
    for (int k = 0; k < 4; ++k) {
        const int from = order[static_cast<std::size_t>(k)];
        sorted[static_cast<std::size_t>(k)] = corners[static_cast<std::size_t>(from)];
        for (int l = k; l < 4; ++l)
            of_sorted[place_of(k, l)] =
                coefficients[place_of(from, order[static_cast<std::size_t>(l)])];
    }
    mesh.tetrahedra.push_back(sorted);
    mesh.coefficients.push_back(of_sorted);
}

void check(std::span<const TetrahedralMesh> meshes) {
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        const TetrahedralMesh& mesh = meshes[m];
        check_elements(fmt::format("tetrahedra {}", m), "", mesh.vertices_world, mesh.tetrahedra);
        if (mesh.coefficients.size() != mesh.tetrahedra.size())
            throw InputError(fmt::format("tetrahedra {}: {} functions for {} tetrahedra", m,
                                         mesh.coefficients.size(), mesh.tetrahedra.size()));
        for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
            const auto& corners = mesh.tetrahedra[i];
            if (!std::ranges::is_sorted(corners) ||
                std::ranges::adjacent_find(corners) != corners.end())
                throw InputError(fmt::format("tetrahedra {}: {}: its corners do not rise", m, i));
            if (!std::ranges::all_of(mesh.coefficients[i],
                                     [](float c) { return std::isfinite(c); }))
                throw InputError(
                    fmt::format("tetrahedra {}: {}: its function is not finite", m, i));
        }
    }
}

bool is_without_volume(const Tetrahedron& tetrahedron) {
    const auto& [a, b, c, d] = tetrahedron.corners_world;
    return (b - a).cross(c - a).dot(d - a) == 0;
}

std::optional<TetrahedronHit> intersect(const Tetrahedron& tetrahedron, const Vec3d& origin_world,
                                        const Vec3d& direction_world, double t_near) {
    // l = base + t way: barycentric coordinates along the ray.
    const Eigen::Matrix<double, 3, 4> gradients = tetrahedron.barycentric_gradients();
    Eigen::Vector4d base;
    for (Eigen::Index k = 0; k < 4; ++k) // from a corner where it is 0
        base[k] = gradients.col(k).dot(
            origin_world - tetrahedron.corners_world[static_cast<std::size_t>((k + 1) % 4)]);
    const Eigen::Vector4d way = gradients.transpose() * direction_world;
    double from = t_near;
    double to = std::numeric_limits<double>::infinity();
    for (Eigen::Index k = 0; k < 4; ++k) {
        const double t = -base[k] / way[k];
        if (way[k] > 0)
            from = std::max(from, t);
        else if (way[k] < 0)
            to = std::min(to, t);
        else if (base[k] < 0)
            return std::nullopt;
    }
    // Roots are counted from the middle of what is within: far away ones would cancel.
    if (!(from <= to)) return std::nullopt;
    const double middle = from + (to - from) / 2;
    base += middle * way;
    const Eigen::Matrix4d& c = tetrahedron.coefficients;
    const double alpha = way.dot(c * way);
    const double beta = base.dot(c * way);
    const double gamma = base.dot(c * base);
    const double discriminant = beta * beta - alpha * gamma;
    if (!(discriminant >= 0)) return std::nullopt;
    const double q = -(beta + std::copysign(std::sqrt(discriminant), beta));
    double first = std::numeric_limits<double>::infinity();
    for (const double s : {q / alpha, gamma / q})
        if (middle + s >= from && middle + s <= to) first = std::min(first, s);
    if (!std::isfinite(first)) return std::nullopt;
    const Vec3d gradient = gradients * (c * (base + first * way));
    return TetrahedronHit{middle + first, gradient.isZero(0) ? Vec3d(-direction_world.normalized())
                                                             : Vec3d(gradient.stableNormalized())};
}

} // namespace isocast
