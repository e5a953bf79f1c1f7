// What is drawn around primitives, and how much of it misses them.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/quadrics_bench.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <numbers>
#include <random>

namespace isocast {

namespace {

constexpr double radius_pixels = 40; // so large that a share of a pixel is little

/// Of the faces of a polyhedron.
struct Polyhedron {
    const char* name;
    std::vector<Vec3d> normals;
    double face_area; // with the unit sphere within
};

Polyhedron cube() {
    return {"cube", {Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()}, 4};
}
Polyhedron icosahedron() {
    Polyhedron found{"icosahedron", {}, 0};
    // Its normals are the corners of a dodecahedron; one of each two that are opposite.
    const double phi = std::numbers::phi;
    for (const double sign : {-1.0, 1.0}) {
        found.normals.emplace_back(0, sign / phi, phi);
        found.normals.emplace_back(sign / phi, phi, 0);
        found.normals.emplace_back(phi, 0, sign / phi);
        for (const double other : {-1.0, 1.0}) found.normals.emplace_back(sign, other, 1);
    }
    for (Vec3d& normal : found.normals) normal.normalize();
    // An edge of length a has an inner sphere of radius phi^2 a / (2 sqrt(3)).
    const double edge = 2 * std::sqrt(3) / (phi * phi);
    found.face_area = std::sqrt(3) / 4 * edge * edge;
    return found;
}

/// Around a sphere that is far away: shares of the polyhedron's picture beside the sphere's.
void print_polyhedron(const Polyhedron& polyhedron) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    double least = 1, most = 0, area_sum = 0;
    constexpr int views = 1000000;
    for (int i = 0; i < views; ++i) {
        const double x = normal(random);
        const double y = normal(random);
        const Vec3d view = Vec3d(x, y, normal(random)).normalized();
        double area = 0; // faces that are seen; as many are not
        for (const Vec3d& face : polyhedron.normals)
            area += polyhedron.face_area * std::abs(face.dot(view));
        const double waste = 1 - std::numbers::pi / area;
        least = std::min(least, waste);
        most = std::max(most, waste);
        area_sum += area;
    }
    fmt::print("a sphere in the {:<12} {:>5.1f} % to {:.1f} %, {:.1f} % of all fragments\n",
               fmt::format("{}:", polyhedron.name), 100 * least, 100 * most,
               100 * (1 - std::numbers::pi * views / area_sum));
}

} // namespace

void run_bounding_shapes(Renderer& renderer) {
    fmt::print("\nToledo and Levy, table 1: share of fragments that miss, each kind turned at "
               "random, {} pixels in radius\n{:<14} {:>12} {:>12} {:>12}\n",
               radius_pixels, "", "ours", "upright box", "point sprite");
    for (std::size_t k = 0; k < specimen_names.size(); ++k) {
        const Specimens some = specimens(static_cast<Specimen>(k), radius_pixels);
        renderer.load({.primitives = std::make_shared<Primitives>(some.primitives)});
        fmt::print("{:<14}", specimen_names[k]);
        for (const BoundingShape shape :
             {BoundingShape::Rectangle, BoundingShape::Box, BoundingShape::Square}) {
            // Of triangles it is always another one.
            if (static_cast<Specimen>(k) == Specimen::Triangle && shape != BoundingShape::Rectangle)
                continue;
            renderer.set_study({.shape = shape, .counts_fragments = true});
            const SplatFragments fragments =
                renderer.draw(some.camera, specimens_width, specimens_height, {FrameImage::Splat})
                    .splat_fragments.value();
            fmt::print(" {:>10.1f} %",
                       100 * (1 - double(fragments.hit) / double(fragments.rasterised)));
        }
        fmt::print("\n");
        std::fflush(stdout);
    }
    renderer.set_study({});
    print_polyhedron(cube());
    print_polyhedron(icosahedron());
}

} // namespace isocast
