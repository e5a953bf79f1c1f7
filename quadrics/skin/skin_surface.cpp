// SPDX-License-Identifier: MPL-2.0
#include "quadrics/skin/skin_surface.h"

#include "volume/errors.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Skin_surface_3.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

namespace isocast {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Traits = CGAL::Skin_surface_traits_3<Kernel>;
using Skin = CGAL::Skin_surface_3<Traits>;

/// Collects the tetrahedra that may hold a piece of the surface, cut until no edge is longer than
/// `longest`: floats know a function's values to their greatest.
class Pieces {
public:
    explicit Pieces(double longest_world) : longest2_(longest_world * longest_world) {
        mesh_.is_closed = true;
    }

    int vertex(const Vec3d& p_world) {
        mesh_.vertices_world.push_back(p_world);
        return static_cast<int>(mesh_.vertices_world.size()) - 1;
    }
    /// Halves at the longest edge: faces are cut at their own longest, from either side.
    ///
    /// value  (p_world): quadratic
    template<class Value>
    void add(std::array<int, 4> corners, const Value& value) {
        std::ranges::sort(corners);
        std::array<double, 10> c{}; // of corners, then of tetrahedron_edges
        for (std::size_t k = 0; k < 4; ++k) c[k] = value(at(corners[k]));
        double greatest2 = 0;
        std::size_t longest = 0;
        for (std::size_t e = 0; e < 6; ++e) {
            const auto [a, b] = ends(e);
            const Vec3d &p = at(corners[a]), &q = at(corners[b]);
            c[4 + e] = 2 * value(0.5 * (p + q)) - 0.5 * (c[a] + c[b]);
            // Of equals the first: corners are in order, which faces keep.
            if (const double length2 = (q - p).squaredNorm(); length2 > greatest2) {
                greatest2 = length2;
                longest = e;
            }
        }
        const auto [least, greatest] = std::ranges::minmax(c);
        if (least > 0 || greatest < 0) return;
        if (greatest2 > longest2_) {
            const auto [a, b] = ends(longest);
            const int middle = between(corners[a], corners[b]);
            for (const std::size_t end : {a, b}) {
                std::array<int, 4> half = corners;
                half[end] = middle;
                add(half, value);
            }
            return;
        }
        std::array<float, 10> coefficients{};
        for (std::size_t k = 0; k < 4; ++k) coefficients[k] = known(corners[k], corners[k], c[k]);
        for (std::size_t e = 0; e < 6; ++e) {
            const auto [a, b] = ends(e);
            coefficients[4 + e] = known(corners[a], corners[b], c[4 + e]);
        }
        append(mesh_, corners, coefficients);
    }
    /// Without the vertices that no tetrahedron has, in their order.
    TetrahedralMesh take() {
        std::vector<int> numbers(mesh_.vertices_world.size(), -1);
        for (const auto& corners : mesh_.tetrahedra)
            for (const int corner : corners) numbers[static_cast<std::size_t>(corner)] = 0;
        std::vector<Vec3d> kept;
        for (std::size_t v = 0; v < numbers.size(); ++v) {
            if (numbers[v] < 0) continue;
            numbers[v] = static_cast<int>(kept.size());
            kept.push_back(mesh_.vertices_world[v]);
        }
        for (auto& corners : mesh_.tetrahedra)
            for (int& corner : corners) corner = numbers[static_cast<std::size_t>(corner)];
        mesh_.vertices_world = std::move(kept);
        return std::move(mesh_);
    }

private:
    using Edge = std::array<int, 2>;
    static std::array<std::size_t, 2> ends(std::size_t edge) {
        return {static_cast<std::size_t>(tetrahedron_edges[edge][0]),
                static_cast<std::size_t>(tetrahedron_edges[edge][1])};
    }
    const Vec3d& at(int vertex) const {
        return mesh_.vertices_world[static_cast<std::size_t>(vertex)];
    }
    int between(int a, int b) {
        const auto [place, is_new] = middles_.try_emplace({a, b}, -1);
        if (is_new) place->second = vertex(0.5 * (at(a) + at(b)));
        return place->second;
    }
    /// By the first that asks: neighbours' functions agree there but for roundings.
    float known(int a, int b, double coefficient) {
        return shared_.try_emplace({a, b}, static_cast<float>(coefficient)).first->second;
    }

    double longest2_;
    TetrahedralMesh mesh_;
    std::map<Edge, int> middles_;
    std::map<Edge, float> shared_;
};

} // namespace

TetrahedralMesh skin_surface(std::span<const Sphere> spheres, double shrink) {
    if (spheres.empty()) throw InputError("a skin needs a sphere");
    if (!(shrink > 0 && shrink < 1))
        throw InputError(fmt::format("a skin's shrink factor {} is not between 0 and 1", shrink));
    std::vector<Skin::Weighted_point> balls;
    double greatest_radius = 0;
    Eigen::AlignedBox3d box;
    for (const Sphere& sphere : spheres) {
        const Vec3d& c = sphere.centre_world;
        box.extend(c);
        greatest_radius = std::max(greatest_radius, sphere.radius_world);
        balls.emplace_back(Skin::Bare_point(c.x(), c.y(), c.z()),
                           sphere.radius_world * sphere.radius_world);
    }
    // CGAL's own frame is so near to few balls that it bends their skin; it grows with the box of
    // all. Beyond 4 R / s, spheres without points stay out of mixed cells that have any of it.
    const double away = 8 * greatest_radius / shrink;
    for (const Vec3d& corner : {Vec3d(box.min().array() - away), Vec3d(box.max().array() + away)})
        balls.emplace_back(Skin::Bare_point(corner.x(), corner.y(), corner.z()),
                           -greatest_radius * greatest_radius);
    Skin skin(balls.begin(), balls.end(), shrink);
    auto& complex = skin.triangulated_mixed_complex();

    Pieces pieces(2 * greatest_radius);
    std::map<Skin::TMC::Vertex_handle, int> numbers;
    for (auto v = complex.finite_vertices_begin(); v != complex.finite_vertices_end(); ++v) {
        const auto& p = v->point();
        numbers.emplace(v, pieces.vertex({CGAL::to_double(p.x()), CGAL::to_double(p.y()),
                                          CGAL::to_double(p.z())}));
    }
    for (auto cell = complex.finite_cells_begin(); cell != complex.finite_cells_end(); ++cell) {
        const auto& function = *cell->info().second;
        std::array<int, 4> corners{};
        for (int k = 0; k < 4; ++k)
            corners[static_cast<std::size_t>(k)] = numbers.at(cell->vertex(k));
        pieces.add(corners, [&](const Vec3d& p) {
            return function.value(Kernel::Point_3(p.x(), p.y(), p.z()));
        });
    }
    return pieces.take();
}

} // namespace isocast
