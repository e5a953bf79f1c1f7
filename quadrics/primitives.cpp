// SPDX-License-Identifier: MPL-2.0
#include "quadrics/primitives.h"

#include "quadrics/slim_blend.h"
#include "quadrics/superquadric.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace isocast {

namespace {

/// Calls problem_of(primitive), empty if there is none, until one has one.
template<class Primitive, class ProblemOf>
void check_each(const char* kind, std::span<const Primitive> primitives, ProblemOf problem_of) {
    for (std::size_t i = 0; i < primitives.size(); ++i)
        if (const std::string problem = problem_of(primitives[i]); !problem.empty())
            throw InputError(fmt::format("{} {}: {}", kind, i, problem));
}

std::string length_problem(const char* name, double length) {
    return std::isfinite(length) && length > 0 ? "" : fmt::format("{} is {}", name, length);
}

std::string axis_problem(const Vec3d& a_world, const Vec3d& b_world) {
    if (!a_world.allFinite() || !b_world.allFinite()) return "an end is not finite";
    return a_world == b_world ? "its ends are one point" : "";
}

std::string axes_problem(const Vec3d& centre_world, const Mat3d& axes_world) {
    if (!centre_world.allFinite() || !axes_world.allFinite()) return "it is not finite";
    return axes_world.determinant() == 0 ? "its axes lie in a plane" : "";
}

std::string first_of(std::initializer_list<std::string> problems) {
    for (const std::string& problem : problems)
        if (!problem.empty()) return problem;
    return "";
}

} // namespace

void check(std::span<const Sphere> spheres) {
    check_each("sphere", spheres, [](const Sphere& s) {
        return first_of({s.centre_world.allFinite() ? "" : "its centre is not finite",
                         length_problem("its radius", s.radius_world)});
    });
}

void check(std::span<const Ellipsoid> ellipsoids) {
    check_each("ellipsoid", ellipsoids,
               [](const Ellipsoid& e) { return axes_problem(e.centre_world, e.axes_world); });
}

void check(std::span<const Cylinder> cylinders) {
    check_each("cylinder", cylinders, [](const Cylinder& c) {
        return first_of(
            {axis_problem(c.a_world, c.b_world), length_problem("its radius", c.radius_world)});
    });
}

void check(std::span<const Cone> cones) {
    check_each("cone", cones, [](const Cone& c) {
        const auto problem_of = [](const char* name, double radius, double other) {
            return radius == 0 && other > 0 ? "" : length_problem(name, radius);
        };
        return first_of({axis_problem(c.a_world, c.b_world),
                         problem_of("its first radius", c.radius_a_world, c.radius_b_world),
                         problem_of("its second radius", c.radius_b_world, c.radius_a_world)});
    });
}

void check(std::span<const ClippedQuadric> quadrics) {
    check_each("quadric", quadrics, [](const ClippedQuadric& q) {
        const bool is_finite = q.a.allFinite() && q.b.allFinite() && std::isfinite(q.c);
        return first_of({axes_problem(q.centre_world, q.axes_world),
                         is_finite ? "" : "its coefficients are not finite",
                         q.a.isZero(0) && q.b.isZero(0) ? "it has no coefficients" : ""});
    });
}

void check(std::span<const Superquadric> superquadrics) {
    check_each("superquadric", superquadrics, [](const Superquadric& s) {
        const auto problem_of = [](double exponent) {
            return exponent >= least_superquadric_exponent && exponent <= 1
                       ? ""
                       : fmt::format("an exponent is {}, not from {} to 1", exponent,
                                     least_superquadric_exponent);
        };
        return first_of(
            {axes_problem(s.centre_world, s.axes_world), problem_of(s.alpha), problem_of(s.beta)});
    });
}

void check(std::span<const Dot> dots) {
    check_each("dot", dots, [](const Dot& d) {
        return first_of({d.centre_world.allFinite() ? "" : "its centre is not finite",
                         length_problem("its radius", d.radius_pixels)});
    });
}

void check(const Primitives& primitives) {
    constexpr std::size_t most = (1U << 24) - 2;
    if (primitives.count() > most)
        throw InputError(fmt::format("{} primitives: {} at most", primitives.count(), most));
    for_each_kind(primitives, [](const auto& some) { check(std::span(some)); });
    check(std::span(primitives.meshes));
    check(std::span(primitives.patches));
    check(std::span(primitives.tetrahedra));
    for (const SlimSurface& surface : primitives.slims) check(surface);
    check(std::span(primitives.dots));
}

namespace {

/// Of points at most `half` from `centre` along each axis.
void extend(Eigen::AlignedBox3d& box, const Vec3d& centre, const Vec3d& half) {
    box.extend(Vec3d(centre - half));
    box.extend(Vec3d(centre + half));
}

/// Half the extent of a disc across the unit vector `axis`.
Vec3d half_extent_of_disc(const Vec3d& axis, double radius) {
    return radius * (1 - axis.array().square()).max(0).sqrt();
}

} // namespace

namespace {

template<class Mesh>
void extend_by(Eigen::AlignedBox3d& box, const Mesh& mesh) {
    for (const Vec3d& vertex : mesh.vertices_world) box.extend(vertex);
}
void extend_by(Eigen::AlignedBox3d& box, const SlimSurface& surface) {
    for (const SlimLevel& level : surface.levels)
        for (const SlimPatch& patch : level.patches)
            for (int axis = 0; axis < 3; ++axis)
                for (const int side : {-1, 1}) {
                    const Vec3d d = side * Vec3d::Unit(axis);
                    box.extend(Vec3d(patch.centre_world + support(patch, d) * d));
                }
}

} // namespace

Eigen::AlignedBox3d box_of(const Primitives& primitives) {
    Eigen::AlignedBox3d box;
    for (const Dot& d : primitives.dots) box.extend(d.centre_world);
    for (const Sphere& s : primitives.spheres)
        extend(box, s.centre_world, Vec3d::Constant(s.radius_world));
    for (const Ellipsoid& e : primitives.ellipsoids)
        extend(box, e.centre_world, e.axes_world.rowwise().norm());
    const auto extend_between = [&](const Vec3d& a, const Vec3d& b, double radius_a,
                                    double radius_b) {
        const Vec3d axis = (b - a).stableNormalized();
        extend(box, a, half_extent_of_disc(axis, radius_a));
        extend(box, b, half_extent_of_disc(axis, radius_b));
    };
    for (const Cylinder& c : primitives.cylinders)
        extend_between(c.a_world, c.b_world, c.radius_world, c.radius_world);
    for (const Cone& c : primitives.cones)
        extend_between(c.a_world, c.b_world, c.radius_a_world, c.radius_b_world);
    for (const ClippedQuadric& q : primitives.quadrics)
        extend(box, q.centre_world, q.axes_world.cwiseAbs().rowwise().sum());
    for_each_mesh(primitives, [&](const auto& mesh) { extend_by(box, mesh); });
    for (const Superquadric& s : primitives.superquadrics)
        extend(
            box, s.centre_world,
            {support(s, Vec3d::UnitX()), support(s, Vec3d::UnitY()), support(s, Vec3d::UnitZ())});
    return box;
}

namespace {

/// Of a disc with its middle at c.
Vec3d farthest_of_disc(const Vec3d& c, const Vec3d& axis, double radius, const Vec3d& d) {
    return c + radius * (d - axis.dot(d) * axis).stableNormalized();
}

Vec3d farthest_of_discs(const Vec3d& a, const Vec3d& b, double radius_a, double radius_b,
                        const Vec3d& d) {
    const Vec3d axis = (b - a).stableNormalized();
    const Vec3d at_a = farthest_of_disc(a, axis, radius_a, d);
    const Vec3d at_b = farthest_of_disc(b, axis, radius_b, d);
    return d.dot(at_a) > d.dot(at_b) ? at_a : at_b;
}

} // namespace

Vec3d farthest_point(const Sphere& s, const Vec3d& d) {
    return s.centre_world + s.radius_world * d.stableNormalized();
}
Vec3d farthest_point(const Ellipsoid& e, const Vec3d& d) {
    return e.centre_world + e.axes_world * (e.axes_world.transpose() * d).stableNormalized();
}
Vec3d farthest_point(const Cylinder& c, const Vec3d& d) {
    return farthest_of_discs(c.a_world, c.b_world, c.radius_world, c.radius_world, d);
}
Vec3d farthest_point(const Cone& c, const Vec3d& d) {
    return farthest_of_discs(c.a_world, c.b_world, c.radius_a_world, c.radius_b_world, d);
}
Vec3d farthest_point(const ClippedQuadric& q, const Vec3d& d) {
    return q.centre_world + q.axes_world * (q.axes_world.transpose() * d).cwiseSign();
}

namespace {

template<class Mesh, class Offer>
void offer_all(const Mesh& mesh, const Vec3d&, Offer offer) {
    for (const Vec3d& vertex : mesh.vertices_world) offer(vertex);
}
template<class Offer>
void offer_all(const SlimSurface& surface, const Vec3d& d, Offer offer) {
    for (const SlimPatch& patch : surface.levels.front().patches)
        offer(Vec3d(patch.centre_world + support(patch, d) * d));
}

} // namespace

std::vector<Vec3d> extreme_points(const Primitives& primitives) {
    constexpr int count = 128;
    std::vector<Vec3d> points;
    for (int i = 0; i < count; ++i) {
        // A spiral from pole to pole by the golden angle.
        const double z = 1 - (2 * i + 1.0) / count;
        const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const double r = std::sqrt(1 - z * z);
        const Vec3d d(r * std::cos(angle), r * std::sin(angle), z);
        double farthest = -std::numeric_limits<double>::infinity();
        Vec3d point = Vec3d::Zero();
        const auto offer = [&](const Vec3d& p) {
            if (!(d.dot(p) > farthest)) return;
            farthest = d.dot(p);
            point = p;
        };
        for (const Dot& dot : primitives.dots) offer(dot.centre_world);
        for_each_kind(primitives, [&](const auto& some) {
            for (const auto& one : some) offer(farthest_point(one, d));
        });
        for_each_mesh(primitives, [&](const auto& mesh) { offer_all(mesh, d, offer); });
        if (std::isfinite(farthest)) points.push_back(point);
    }
    return points;
}

} // namespace isocast
