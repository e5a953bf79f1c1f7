// Surfaces that are drawn one by one: spheres, ellipsoids, cylinders, cones, general quadrics in a
// box, and triangles.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/triangles.h"

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

/// throws  InputError that names the first one that cannot be drawn by its index, and why: a length
///         that is zero, negative, NaN or infinite, a place that is not finite, axes that lie in a
///         plane, a quadric without coefficients
void check(std::span<const Sphere> spheres);
void check(std::span<const Ellipsoid> ellipsoids);
void check(std::span<const Cylinder> cylinders);
void check(std::span<const Cone> cones);
void check(std::span<const ClippedQuadric> quadrics);

/// All that a scene draws one by one.
struct Primitives {
    std::vector<Sphere> spheres;
    std::vector<Ellipsoid> ellipsoids;
    std::vector<Cylinder> cylinders;
    std::vector<Cone> cones;
    std::vector<ClippedQuadric> quadrics;
    std::vector<TriangleMesh> meshes;

    std::size_t quadric_count() const {
        return spheres.size() + ellipsoids.size() + cylinders.size() + cones.size() +
               quadrics.size();
    }
    std::size_t triangle_count() const {
        std::size_t sum = 0;
        for (const TriangleMesh& mesh : meshes) sum += mesh.triangles.size();
        return sum;
    }
    std::size_t count() const { return quadric_count() + triangle_count(); }
};
/// throws  InputError as above, or for more than 2^24 - 2: beyond it floats do not count
void check(const Primitives& primitives);

/// Along the world's axes, around all of them: tight for spheres, ellipsoids, cylinders and cones,
/// for clipped quadrics that of their boxes, for meshes that of their vertices. Empty if there are
/// none.
Eigen::AlignedBox3d box_of(const Primitives& primitives);

/// The farthest points of all of them in 128 directions, evenly spread: their convex hull has that
/// of the primitives within 1.5 % of its width; of clipped quadrics that of their boxes.
std::vector<Vec3d> extreme_points(const Primitives& primitives);

} // namespace isocast
