// What is drawn one by one: spheres, ellipsoids, cylinders, cones, general quadrics in a box,
// superquadrics, triangles, bilinear patches, quadrics in tetrahedra and SLIM surfaces.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/bilinear.h"
#include "quadrics/slim.h"
#include "quadrics/tetrahedra.h"
#include "quadrics/triangles.h"

#include <optional>
#include <span>
#include <vector>

namespace isocast {

/// Inside is negative, as in fields: |p - centre| - radius.
struct Sphere {
    Vec3d centre_world = Vec3d::Zero();
    double radius_world = 1;
    Vec3d colour = Vec3d(0.72, 0.6, 0.42); // linear
};

/// The image of the unit sphere by p = centre + axes q; columns are the semi-axes.
struct Ellipsoid {
    Vec3d centre_world = Vec3d::Zero();
    Mat3d axes_world = Mat3d::Identity();
    Vec3d colour = Vec3d(0.72, 0.6, 0.42);
};

/// From the middle of one end to that of the other; open: without the two discs.
struct Cylinder {
    Vec3d a_world = Vec3d::Zero();
    Vec3d b_world = Vec3d::UnitZ();
    double radius_world = 1;
    bool is_capped = false;
    Vec3d colour = Vec3d(0.72, 0.6, 0.42);
    std::optional<Vec3d> colour_b = {}; // of the half at b, if it has another
};

/// With another radius at each end, one of which may be 0: the apex.
struct Cone {
    Vec3d a_world = Vec3d::Zero();
    Vec3d b_world = Vec3d::UnitZ();
    double radius_a_world = 1;
    double radius_b_world = 0;
    bool is_capped = true;
    Vec3d colour = Vec3d(0.72, 0.6, 0.42);
};

/// q^T A q + 2 b^T q + c = 0 with q = axes^-1 (p - centre), where |q_x|, |q_y|, |q_z| <= 1: the box
/// that clips it has the columns of `axes` as half edges.
struct ClippedQuadric {
    Vec3d centre_world = Vec3d::Zero();
    Mat3d axes_world = Mat3d::Identity();
    Mat3d a = Mat3d::Identity(); // symmetric
    Vec3d b = Vec3d::Zero();
    double c = -1;
    Vec3d colour = Vec3d(0.72, 0.6, 0.42);
};

// 2 / 0.05 = 40: edges as round as 1/40 of the size; sharper ones would only alias.
inline constexpr double least_superquadric_exponent = 0.05;

/// The image by p = centre + axes q of (|q_x|^(2/alpha) + |q_y|^(2/alpha))^(alpha/beta) +
/// |q_z|^(2/beta) = 1: a ball with alpha = beta = 1, nearly a cylinder along z with alpha = 1 and
/// a small beta, nearly a box with both small.
struct Superquadric {
    Vec3d centre_world = Vec3d::Zero();
    Mat3d axes_world = Mat3d::Identity(); // columns: the semi-axes
    double alpha = 1;                     // around z
    double beta = 1;                      // along z
    Vec3d colour = Vec3d(0.72, 0.6, 0.42);
};

/// A sphere that is as large on every picture, near or far: the lesser semi-axis of its image has
/// so many pixels.
struct Dot {
    Vec3d centre_world = Vec3d::Zero();
    double radius_pixels = 1;
    Vec3d colour = Vec3d(0.72, 0.6, 0.42);
};

/// throws  InputError that names the first one that cannot be drawn by its index, and why: a length
///         that is zero, negative, NaN or infinite, a place that is not finite, axes that lie in a
///         plane, a quadric without coefficients, an exponent that is not from 0.05 to 1
void check(std::span<const Sphere> spheres);
void check(std::span<const Ellipsoid> ellipsoids);
void check(std::span<const Cylinder> cylinders);
void check(std::span<const Cone> cones);
void check(std::span<const ClippedQuadric> quadrics);
void check(std::span<const Superquadric> superquadrics);
void check(std::span<const Dot> dots);

/// All that a scene draws one by one.
struct Primitives {
    std::vector<Sphere> spheres;
    std::vector<Ellipsoid> ellipsoids;
    std::vector<Cylinder> cylinders;
    std::vector<Cone> cones;
    std::vector<ClippedQuadric> quadrics;
    std::vector<Superquadric> superquadrics;
    std::vector<TriangleMesh> meshes;
    std::vector<PatchMesh> patches;
    std::vector<TetrahedralMesh> tetrahedra;
    std::vector<SlimSurface> slims;
    std::vector<Dot> dots; // spheres once there is a picture: with_dots_as_spheres()

    std::size_t solid_count() const; // of all but meshes and dots
    std::size_t mesh_count() const {
        return meshes.size() + patches.size() + tetrahedra.size() + slims.size();
    }
    std::size_t triangle_count() const { return sum_of(meshes, &TriangleMesh::triangles); }
    std::size_t patch_count() const { return sum_of(patches, &PatchMesh::quads); }
    std::size_t tetrahedron_count() const {
        return sum_of(tetrahedra, &TetrahedralMesh::tetrahedra);
    }
    /// Pieces of the finest levels.
    std::size_t slim_count() const {
        std::size_t sum = 0;
        for (const SlimSurface& surface : slims) sum += surface.levels.front().patches.size();
        return sum;
    }
    std::size_t count() const {
        return solid_count() + triangle_count() + patch_count() + tetrahedron_count() +
               slim_count() + dots.size();
    }

private:
    template<class Mesh, class Elements>
    static std::size_t sum_of(const std::vector<Mesh>& some, Elements Mesh::*elements) {
        std::size_t sum = 0;
        for (const Mesh& mesh : some) sum += (mesh.*elements).size();
        return sum;
    }
};

/// Calls f with the primitives of each kind but meshes and dots, in the order by which all are
/// numbered.
template<class SomePrimitives, class Function>
void for_each_kind(SomePrimitives& primitives, Function f) {
    f(primitives.spheres);
    f(primitives.ellipsoids);
    f(primitives.cylinders);
    f(primitives.cones);
    f(primitives.quadrics);
    f(primitives.superquadrics);
}

/// Calls f with the meshes of each kind, whose numbers follow; SLIM surfaces are the last.
template<class SomePrimitives, class Function>
void for_each_mesh(SomePrimitives& primitives, Function f) {
    for (auto& mesh : primitives.meshes) f(mesh);
    for (auto& mesh : primitives.patches) f(mesh);
    for (auto& mesh : primitives.tetrahedra) f(mesh);
    for (auto& surface : primitives.slims) f(surface);
}

/// Calls f with the primitive of this number, which is none of a mesh or a dot.
template<class Function>
void visit_solid(const Primitives& primitives, std::size_t number, Function f) {
    for_each_kind(primitives, [&](const auto& some) {
        if (number < some.size()) f(some[number]);
        number -= some.size(); // the kinds after it are not as large as what that wraps to
    });
}

inline std::size_t Primitives::solid_count() const {
    std::size_t count = 0;
    for_each_kind(*this, [&](const auto& some) { count += some.size(); });
    return count;
}

/// throws  InputError as above, or for more than 2^24 - 2: beyond it floats do not count
void check(const Primitives& primitives);

/// Along the world's axes, around all of them: tight, but for clipped quadrics that of their boxes,
/// and of dots that of their centres. Empty if there are none.
Eigen::AlignedBox3d box_of(const Primitives& primitives);

/// A point of a primitive that is farthest in the direction d; of clipped quadrics one of their
/// boxes. That of superquadrics is in superquadric.h.
Vec3d farthest_point(const Sphere& sphere, const Vec3d& d);
Vec3d farthest_point(const Ellipsoid& ellipsoid, const Vec3d& d);
Vec3d farthest_point(const Cylinder& cylinder, const Vec3d& d);
Vec3d farthest_point(const Cone& cone, const Vec3d& d);
Vec3d farthest_point(const ClippedQuadric& quadric, const Vec3d& d);

/// The farthest points of all of them in 128 directions, evenly spread: their convex hull has that
/// of the primitives within 1.5 % of its width; of clipped quadrics that of their boxes,
/// of dots that of their centres.
std::vector<Vec3d> extreme_points(const Primitives& primitives);

} // namespace isocast
