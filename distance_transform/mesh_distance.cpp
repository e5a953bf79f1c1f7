// The exact signed distance to a mesh, cube by cube.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh_distance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

/// Height to length of triangles whose frames are not to be trusted: below it the height's
/// direction may be off by 2^-53 / 1e-6 = 1e-10, still nothing beside a float.
constexpr double sliver_ratio = 1e-6;

constexpr std::int32_t leaf_triangles = 4; // which are bounded at once

/// What floats can add to a bound, over the distances of p and the triangle from the origin: eight
/// roundings of 2^-24, in two distances at a right angle.
constexpr double slab_slack = 0x1p-20;

/// How often a triangle is split into four for a better bound: each time what the bend adds is a
/// quarter. At 1e-3 of its size the bunny takes 0.6 times the cells that it takes without.
constexpr int greatest_splits = 3;

/// A bound of |g| on a triangle, from the values at its corners v_k: for any x of it
///   |g(x) - sum w_k g(v_k)| <= bend/2 sum w_k |x - v_k|^2,
/// and that sum is at most the squared radius of a ball around it, diameter^2 / 3 (Jung).
///
/// corners    from `origin`
/// tolerance  bounds above it are of no use
double greatest_on(const std::array<Vec3d, 3>& corners, const CellFunction& g, const Vec3d& origin,
                   double tolerance, int splits) {
    double at_corners = 0;
    double diameter = 0; // squared
    for (std::size_t k = 0; k < 3; ++k) {
        at_corners = std::max(at_corners, std::abs(g.at(origin + corners[k])));
        diameter = std::max(diameter, (corners[k] - corners[(k + 1) % 3]).squaredNorm());
    }
    const double bound = at_corners + g.bounds().bend * diameter / 6;
    if (bound <= tolerance || at_corners > tolerance || splits == 0) return bound;
    const auto& [a, b, c] = corners;
    const Vec3d ab = (a + b) / 2;
    const Vec3d bc = (b + c) / 2;
    const Vec3d ca = (c + a) / 2;
    double greatest = 0;
    for (const std::array<Vec3d, 3>& part :
         {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        if (greatest <= tolerance)
            greatest = std::max(greatest, greatest_on(part, g, origin, tolerance, splits - 1));
    return greatest;
}

std::vector<std::array<Vec3d, 3>> corners_of(const Mesh& mesh) {
    std::vector<std::array<Vec3d, 3>> corners;
    corners.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles)
        corners.push_back({mesh.vertices_world[a], mesh.vertices_world[b], mesh.vertices_world[c]});
    return corners;
}

std::vector<WorldBox> boxes_of(std::span<const std::array<Vec3d, 3>> triangles) {
    std::vector<WorldBox> boxes;
    boxes.reserve(triangles.size());
    for (const auto& [a, b, c] : triangles)
        boxes.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)});
    return boxes;
}

/// The part of a triangle in a cube: a convex polygon of up to nine corners.
class Polygon {
public:
    Polygon(const std::array<Vec3d, 3>& corners, const Cube& cube) {
        for (const Vec3d& corner : corners) points_[count_++] = corner - cube.centre;
        for (int axis = 0; axis < 3 && count_ > 0; ++axis)
            for (const double side : {-1.0, 1.0}) clip(axis, side, cube.half_edge);
    }
    /// From the cube's centre.
    std::span<const Vec3d> points() const { return {points_.data(), count_}; }

private:
    /// Keeps what lies within side * p[axis] <= half_edge (Sutherland & Hodgman 1974).
    void clip(int axis, double side, double half_edge) {
        if (std::ranges::none_of(points(),
                                 [&](const Vec3d& p) { return side * p[axis] > half_edge; }))
            return;
        std::array<Vec3d, 9> kept;
        std::size_t kept_count = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const Vec3d& a = points_[i];
            const Vec3d& b = points_[i + 1 < count_ ? i + 1 : 0];
            const double beyond_a = side * a[axis] - half_edge;
            const double beyond_b = side * b[axis] - half_edge;
            if (beyond_a <= 0) kept[kept_count++] = a;
            if ((beyond_a < 0 && beyond_b > 0) || (beyond_a > 0 && beyond_b < 0)) {
                Vec3d& p = kept[kept_count++];
                p = a + beyond_a / (beyond_a - beyond_b) * (b - a);
                p[axis] = side * half_edge;
            }
        }
        points_ = kept;
        count_ = kept_count;
    }

    std::array<Vec3d, 9> points_;
    std::size_t count_ = 0;
};

} // namespace

MeshDistance::MeshDistance(const Mesh& mesh, const MeshTopology& topology,
                           const WindingNumber* winding)
    : corners_(corners_of(mesh)), tree_(boxes_of(corners_), leaf_triangles),
      normals_(mesh, topology), winding_(winding) {
    frames_.resize(corners_.size());
    tbb::parallel_for(std::size_t{0}, corners_.size(),
                      [&](std::size_t i) { frames_[i] = frame_of(corners_[i]); });
    const WorldBox box = bounding_box(mesh);
    slab_origin_ = (box.min + box.max) / 2;
    slab_radius_ = box.size().norm() / 2;
    add_slabs();
}

MeshDistance::Frame MeshDistance::frame_of(const std::array<Vec3d, 3>& corners) {
    std::size_t k = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if ((corners[(i + 1) % 3] - corners[i]).squaredNorm() >
            (corners[(k + 1) % 3] - corners[k]).squaredNorm())
            k = i;
    const Vec3d edge = corners[(k + 1) % 3] - corners[k];
    const Vec3d to_top = corners[(k + 2) % 3] - corners[k];
    Frame frame{.origin = corners[k], .length = edge.norm(), .first = static_cast<int>(k)};
    frame.x = edge / frame.length;
    frame.top_x = to_top.dot(frame.x);
    const Vec3d up = to_top - frame.top_x * frame.x;
    frame.top_y = up.norm();
    if (frame.top_y < sliver_ratio * frame.length) {
        frame.top_y = 0;
        return frame;
    }
    frame.y = up / frame.top_y;
    frame.normal = frame.x.cross(frame.y);
    const double from_right = frame.length - frame.top_x;
    frame.inverse_right = 1 / (from_right * from_right + frame.top_y * frame.top_y);
    frame.inverse_left = 1 / (frame.top_x * frame.top_x + frame.top_y * frame.top_y);
    return frame;
}

MeshDistance::Closest MeshDistance::closest_on(std::int32_t triangle, const Vec3d& p) const {
    const Frame& frame = frames_[static_cast<std::size_t>(triangle)];
    if (!(frame.top_y > 0)) {
        // As seen from p: far from the origin closest_point loses more than a sliver's height.
        std::array<Vec3d, 3> corners = corners_[static_cast<std::size_t>(triangle)];
        for (Vec3d& corner : corners) corner -= p;
        const ClosestPoint closest = closest_point(Vec3d::Zero(), corners);
        return {-closest.p, closest.feature};
    }
    const Vec3d from_origin = p - frame.origin;
    const double x = from_origin.dot(frame.x);
    const double y = from_origin.dot(frame.y);
    const double z = from_origin.dot(frame.normal);
    const double right_x = x - frame.length;
    const double edge_x = frame.top_x - frame.length;
    if (y >= 0 && edge_x * y - right_x * frame.top_y >= 0 && x * frame.top_y - frame.top_x * y >= 0)
        return {z * frame.normal, Feature::Face};
    // Where the closest points of the longest edge, the right and the left one lie on them, the
    // way round the triangle.
    const std::array<double, 3> along = {
        std::clamp(x / frame.length, 0.0, 1.0),
        std::clamp((right_x * edge_x + y * frame.top_y) * frame.inverse_right, 0.0, 1.0),
        1 - std::clamp((x * frame.top_x + y * frame.top_y) * frame.inverse_left, 0.0, 1.0)};
    const std::array<Eigen::Vector2d, 3> offsets = {
        {{x - along[0] * frame.length, y},
         {right_x - along[1] * edge_x, y - along[1] * frame.top_y},
         {x - (1 - along[2]) * frame.top_x, y - (1 - along[2]) * frame.top_y}}};
    int edge = 0;
    for (int k = 1; k < 3; ++k)
        if (offsets[static_cast<std::size_t>(k)].squaredNorm() <
            offsets[static_cast<std::size_t>(edge)].squaredNorm())
            edge = k;
    const Eigen::Vector2d& offset = offsets[static_cast<std::size_t>(edge)];
    const double t = along[static_cast<std::size_t>(edge)];
    const auto corner = static_cast<std::size_t>((frame.first + edge + (t >= 1 ? 1 : 0)) % 3);
    const auto side = static_cast<std::size_t>((frame.first + edge) % 3);
    return {offset.x() * frame.x + offset.y() * frame.y + z * frame.normal,
            t > 0 && t < 1 ? edge_features[side] : vertex_features[corner]};
}

void MeshDistance::add_slabs() {
    slabs_.resize((corners_.size() + leaf_triangles - 1) / leaf_triangles);
    tbb::parallel_for(std::size_t{0}, corners_.size(), [&](std::size_t place) {
        const Frame& frame = frames_[static_cast<std::size_t>(tree_.order()[place])];
        Slabs& slabs = slabs_[place / leaf_triangles];
        const auto lane = static_cast<Eigen::Index>(place % leaf_triangles);
        // Of the plane, and of those through the edges that look away from the triangle.
        std::array<Vec3d, 4> normals;
        normals.fill(Vec3d::Zero());
        std::array<Vec3d, 4> points;
        points.fill(frame.origin);
        if (frame.top_y > 0) {
            normals[0] = frame.normal;
            normals[1] = -frame.y;
            const double from_right = frame.length - frame.top_x;
            normals[2] =
                (frame.top_y * frame.x + from_right * frame.y) * std::sqrt(frame.inverse_right);
            points[2] += frame.length * frame.x;
            normals[3] =
                (frame.top_x * frame.y - frame.top_y * frame.x) * std::sqrt(frame.inverse_left);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            slabs[k].x[lane] = static_cast<float>(normals[k].x());
            slabs[k].y[lane] = static_cast<float>(normals[k].y());
            slabs[k].z[lane] = static_cast<float>(normals[k].z());
            slabs[k].offset[lane] = static_cast<float>(normals[k].dot(points[k] - slab_origin_));
        }
    });
}

ExactDistance::Sample MeshDistance::at(const Vec3d& p, Hint& hint) const {
    std::int32_t triangle = hint;
    Closest closest = closest_on(triangle, p);
    double squared_distance = closest.offset.squaredNorm();
    const Eigen::Vector3f from_origin = (p - slab_origin_).cast<float>();
    const double slack = slab_slack * ((p - slab_origin_).norm() + slab_radius_);
    const auto reach = [&] {
        const double distance = std::sqrt(squared_distance) + slack;
        return static_cast<float>(distance * distance);
    };
    float squared_reach = reach();
    tree_.visit_near(
        p, [&] { return squared_distance; },
        [&](std::int32_t first, std::int32_t end) {
            const Slabs& slabs = slabs_[static_cast<std::size_t>(first / leaf_triangles)];
            const Floats beyond = slabs[1]
                                      .at(from_origin)
                                      .max(slabs[2].at(from_origin))
                                      .max(slabs[3].at(from_origin))
                                      .max(0);
            const Floats bounds = slabs[0].at(from_origin).square() + beyond.square();
            for (std::int32_t place = first; place < end; ++place) {
                if (!(bounds[place - first] <= squared_reach)) continue;
                const std::int32_t other = tree_.order()[static_cast<std::size_t>(place)];
                const Closest its_closest = closest_on(other, p);
                const double its_squared = its_closest.offset.squaredNorm();
                if (its_squared >= squared_distance) continue;
                closest = its_closest;
                squared_distance = its_squared;
                squared_reach = reach();
                triangle = other;
            }
        });
    hint = triangle;
    const double distance = std::sqrt(squared_distance);
    const Vec3d& normal = normals_.at(triangle, closest.feature);
    const bool is_inside = winding_ ? winding_->is_inside(p) : closest.offset.dot(normal) < 0;
    const double sign = is_inside ? -1 : 1;
    if (distance > 0) return {sign * distance, sign / distance * closest.offset};
    const double length = normal.norm();
    return {0, length > 0 ? Vec3d(normal / length) : Vec3d::Zero()};
}

SurfaceInCube MeshDistance::surface_in(const Cube& cube, const CellFunction& g,
                                       double tolerance) const {
    SurfaceInCube all;
    const Eigen::Vector3f from_origin = (cube.centre - slab_origin_).cast<float>();
    const auto half_edge = static_cast<float>(cube.half_edge);
    const auto slack = static_cast<float>(
        slab_slack * ((cube.centre - slab_origin_).norm() + slab_radius_ + cube.half_edge));
    const auto add = [&](std::int32_t first, std::int32_t end) {
        // By how much a plane parts the triangle from the cube.
        const Slabs& slabs = slabs_[static_cast<std::size_t>(first / leaf_triangles)];
        Floats apart = slabs[0].at(from_origin).abs() - slabs[0].reach(half_edge);
        for (std::size_t k = 1; k < 4; ++k)
            apart = apart.max(slabs[k].at(from_origin) - slabs[k].reach(half_edge));
        for (std::int32_t place = first; place < end; ++place) {
            if (apart[place - first] > slack) continue;
            const std::int32_t triangle = tree_.order()[static_cast<std::size_t>(place)];
            const Polygon polygon(corners_[static_cast<std::size_t>(triangle)], cube);
            if (polygon.points().empty()) continue;
            all.is_there = true;
            const std::span<const Vec3d> points = polygon.points();
            for (const Vec3d& point : points) all.box.extend(point + cube.centre);
            for (std::size_t i = 0; i + 2 < std::max<std::size_t>(points.size(), 3); ++i)
                all.bound = std::max(
                    all.bound, greatest_on({points[0], points[std::min(i + 1, points.size() - 1)],
                                            points[std::min(i + 2, points.size() - 1)]},
                                           g, cube.centre, tolerance, greatest_splits));
        }
    };
    tree_.visit_touching(
        cube.centre, cube.half_edge, [&] { return all.bound <= tolerance; }, add);
    return all;
}

} // namespace isocast
