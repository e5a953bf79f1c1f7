// Distances to single triangles, and winding numbers: slivers, no area at all, far and huge ones.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/brute_force.h"
#include "distance_transform/kd_tree.h"
#include "distance_transform/point_triangle.h"
#include "distance_transform/sample_meshes.h"
#include "distance_transform/winding_number.h"
#include "stability/cases.h"
#include "stability/random.h"
#include "stability/shapes.h"

namespace isocast::stability {

namespace {

// Of slivers even 64 bits tell no normal.
#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 Quad;
#else
using Quad = long double; // which has 113 bits there
#endif
struct Q3 {
    Quad x, y, z;
};
Q3 of(const Vec3d& v) {
    return {v.x(), v.y(), v.z()};
}
Q3 operator-(const Q3& a, const Q3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Q3 operator*(Quad s, const Q3& a) {
    return {s * a.x, s * a.y, s * a.z};
}
Quad dot(const Q3& a, const Q3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Q3 cross(const Q3& a, const Q3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

using Corners = std::array<Vec3d, 3>;

Quad squared_distance_to_segment(const Q3& p, const Q3& a, const Q3& b) {
    const Q3 d = b - a;
    const Quad dd = dot(d, d);
    const Quad t = dd > 0 ? std::clamp<Quad>(dot(p - a, d) / dd, 0, 1) : 0;
    const Q3 offset = p - a - t * d;
    return dot(offset, offset);
}

/// The least of the distances to the edges, and to the plane where the foot lies within: no regions
/// are told apart, as in the function that is judged.
double true_distance(const Vec3d& p_world, const Corners& corners) {
    const Q3 p = of(p_world), a = of(corners[0]), b = of(corners[1]), c = of(corners[2]);
    Quad least =
        std::min({squared_distance_to_segment(p, a, b), squared_distance_to_segment(p, b, c),
                  squared_distance_to_segment(p, c, a)});
    const Q3 n = cross(b - a, c - a);
    const Quad nn = dot(n, n);
    if (nn > 0) {
        const Quad height = dot(p - a, n) / nn;
        const Q3 foot = p - height * n;
        if (dot(cross(b - a, foot - a), n) >= 0 && dot(cross(c - b, foot - b), n) >= 0 &&
            dot(cross(a - c, foot - c), n) >= 0)
            least = std::min(least, height * height * nn);
    }
    return std::sqrt(static_cast<double>(least));
}

/// Errors in roundings of the greatest difference of coordinates.
template<class Make>
Worst triangles(Make make) {
    Random random(1);
    Worst worst;
    for (int i = 0; i < 2000; ++i) {
        const Corners corners = make(random);
        const double size =
            std::max((corners[1] - corners[0]).norm(), (corners[2] - corners[0]).norm());
        // Near it, beside it, and on it.
        const double reach = i % 3 == 0 ? 3 * size : i % 3 == 1 ? 0.1 * size : 0;
        const double s = random.uniform(0, 1), t = random.uniform(0, 1 - s);
        const Vec3d p = corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0]) +
                        reach * random.in_cube() +
                        (size == 0 ? random.unit() : Vec3d(Vec3d::Zero()));
        const double unit = 0x1p-53 * std::max(size, (p - corners[0]).norm());
        const double d = std::sqrt(closest_point(p, corners).squared_distance);
        worst.see(std::abs(d - true_distance(p, corners)) / unit);
    }
    return worst;
}

Corners any_triangle(Random& random) {
    return {random.in_cube(), random.in_cube(), random.in_cube()};
}

/// Its height is a share of its length.
Corners sliver(Random& random, double height) {
    const Vec3d a = random.in_cube(), b = random.in_cube();
    const Vec3d middle = a + random.uniform(0.1, 0.9) * (b - a);
    return {a, b, middle + height * (b - a).cross(random.unit())};
}

Corners mapped(Corners corners, double scale, const Vec3d& shift) {
    for (Vec3d& p : corners) p = scale * p + shift;
    return corners;
}

Worst winding_of_closed_meshes() {
    Random random(2);
    Worst worst;
    for (const Mesh& mesh : {cube(), noisy_sphere(3, 2), sample_mesh("knot")}) {
        const WindingNumber winding(mesh, true);
        for (int i = 0; i < 300; ++i) {
            const Vec3d p = random.in_cube(1.5);
            const double w = brute_force_winding_number(mesh, p);
            worst.must(winding.is_inside(p) == (w > 0.5));
            worst.must(std::abs(w - std::round(w)) < 1e-12);
        }
    }
    return worst;
}

/// A ray through an edge or a corner: where the parity of crossings fails, even of a cube.
Worst winding_behind_edges() {
    const WindingNumber winding(cube(), true);
    Worst worst;
    for (const double z : {-1.0, -0.5, 0.0, 0.5, 1.0})
        for (const double far : {1.5, 3.0, 100.0}) {
            worst.must(!winding.is_inside({far, 1, z}));
            worst.must(!winding.is_inside({-far, -1, z}));
            worst.must(!winding.is_inside({far, far, z}));
            worst.must(winding.is_inside({0.999, 0, 0.999 * z}));
        }
    return worst;
}

Worst kd_trees_find_what_brute_force_finds(const Mesh& mesh) {
    const KdTree tree(mesh);
    Random random(4);
    Worst worst;
    for (int i = 0; i < 500; ++i) {
        const Vec3d p = random.in_cube(i % 2 ? 1.5 : 20);
        const auto nearest = tree.closest(p);
        worst.must(nearest.has_value());
        if (!nearest) continue;
        const double d = brute_force_distance(mesh, p);
        worst.see(std::abs(std::sqrt(nearest->closest.squared_distance) - d) /
                  (0x1p-53 * std::max(1.0, p.norm())));
    }
    return worst;
}

/// Rays through the shared edges and corners of a closed mesh, which may not slip between.
Worst rays_through_edges_hit() {
    const Mesh mesh = sample_mesh("knot");
    const KdTree tree(mesh);
    Random random(5);
    Worst worst;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3d& corner = mesh.vertices_world[static_cast<std::size_t>(a)];
        const Vec3d& next = mesh.vertices_world[static_cast<std::size_t>(b)];
        for (const Vec3d& target : {corner, Vec3d(0.5 * (corner + next))}) {
            // From inside, whatever way it takes, a ray leaves the solid.
            const Vec3d normal =
                (next - corner).cross(mesh.vertices_world[static_cast<std::size_t>(c)] - corner);
            const Vec3d inside = target - 1e-4 * normal.normalized();
            if (brute_force_winding_number(mesh, inside) < 0.5) continue;
            worst.must(tree.first_hit(inside, target - inside).has_value());
        }
    }
    return worst;
}

} // namespace

void append_triangle_cases(std::vector<Case>& cases) {
    const auto add = [&](const std::string& name, const char* compares, double bound,
                         const char* from, auto run) {
        cases.push_back(
            {"triangle." + name, compares, bound, from, [run](Devices&) { return run(); }});
    };
    const auto distances = [&](const std::string& name, auto make, double bound = 32,
                               const char* from = "products of differences, of which none cancels "
                                                  "twice, and a root") {
        add(name,
            "closest_point() and the least of edges and plane in 113 bits [roundings of the size]",
            bound, from, [make] { return triangles(make); });
    };
    distances("any", any_triangle);
    for (const char* height : {"1e-05", "1e-09", "1e-13"})
        distances(
            std::string("sliver-") + height,
            [h = std::stod(height)](Random& random) { return sliver(random, h); },
            // In roundings; where the face counts it is as exact as any.
            height == std::string_view("1e-05") ? 32 : 0.5e-10 / 0x1p-53,
            "below 1e-10 of its length a face is left out: half of that");
    distances("no-area", [](Random& random) -> Corners {
        // Halves of multiples of 2^-20 are exact.
        const Vec3d a = (random.in_cube() * 0x1p20).array().round() * 0x1p-20;
        const Vec3d b = (random.in_cube() * 0x1p20).array().round() * 0x1p-20;
        return {a, b, 0.5 * (a + b)};
    });
    distances("one-point", [](Random& random) -> Corners {
        const Vec3d p = random.in_cube();
        return {p, p, p};
    });
    for (const double scale : {1e-12, 1e12})
        distances(scale < 1 ? "scale-1e-12" : "scale-1e12", [scale](Random& random) {
            return mapped(any_triangle(random), scale, Vec3d::Zero());
        });
    distances("origin-1e8", [](Random& random) {
        return mapped(any_triangle(random), 1, Vec3d(1e8, -2e8, 1.5e8));
    });
    add("winding-of-closed-meshes", "winding numbers by the hierarchy and the sum over all", 0,
        "the same side everywhere", winding_of_closed_meshes);
    add("winding-behind-edges", "sides of a cube behind its edges and corners", 0, "known",
        winding_behind_edges);
    add("kd-tree-of-slivers", "closest triangles by tree and brute force [roundings]", 32,
        "as closest_point()", [] {
            return kd_trees_find_what_brute_force_finds(with_slivers(noisy_sphere(1, 2), 1e-9));
        });
    add("kd-tree-of-a-soup", "closest triangles by tree and brute force [roundings]", 32,
        "as closest_point()",
        [] { return kd_trees_find_what_brute_force_finds(unindexed(noisy_sphere(7, 2))); });
    add("rays-through-edges", "rays from inside a closed mesh through edges and corners hit it", 0,
        "none may slip between", rays_through_edges_hit);
}

} // namespace isocast::stability
