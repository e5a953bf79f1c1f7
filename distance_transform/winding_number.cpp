// Generalised winding number of a triangle soup by a hierarchy of dipoles.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/winding_number.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace isocast {

namespace {

constexpr double far_ratio = 2; // the beta of Barill et al., section 4, and their value
// A triangle costs about as much as a node's visit; the product of four of the complex numbers
// below neither overflows nor vanishes.
constexpr std::int32_t leaf_size = 4;

Vec3d centroid_of(const std::array<Vec3d, 3>& triangle) {
    return (triangle[0] + triangle[1] + triangle[2]) / 3;
}

/// Half the solid angle of a few triangles.
///
/// That of one triangle is the argument of a complex number (van Oosterom & Strackee 1983); the
/// numbers are multiplied, and turns past the negative real axis counted, to call atan2 once.
double half_solid_angle(std::span<const std::array<Vec3d, 3>> triangles, const Vec3d& p) {
    double real = 1;
    double imaginary = 0;
    int turns = 0;
    for (const std::array<Vec3d, 3>& triangle : triangles) {
        const Vec3d a = triangle[0] - p;
        const Vec3d b = triangle[1] - p;
        const Vec3d c = triangle[2] - p;
        const double la = a.norm();
        const double lb = b.norm();
        const double lc = c.norm();
        const double x = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        const double y = a.dot(b.cross(c));
        const double product = real * y + imaginary * x;
        if (imaginary > 0 && y > 0 && product < 0) ++turns;
        if (imaginary < 0 && y < 0 && product >= 0) --turns;
        real = real * x - imaginary * y;
        imaginary = product;
    }
    return std::atan2(imaginary, real) + 2 * std::numbers::pi * turns;
}

} // namespace

WindingNumber::WindingNumber(const Mesh& mesh, bool is_closed) : is_closed_(is_closed) {
    triangles_.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles)
        triangles_.push_back(
            {mesh.vertices_world[a], mesh.vertices_world[b], mesh.vertices_world[c]});
    nodes_.reserve(triangles_.size() / 2);
    build(0, static_cast<std::int32_t>(triangles_.size()));
}

void WindingNumber::build(std::int32_t first, std::int32_t count) {
    const auto begin = triangles_.begin() + first;
    const auto end = begin + count;
    Node node;
    node.area_normal = Vec3d::Zero();
    double area = 0;
    Vec3d weighted = Vec3d::Zero();
    Vec3d least = centroid_of(*begin);
    Vec3d greatest = least;
    for (auto triangle = begin; triangle != end; ++triangle) {
        const auto& [a, b, c] = *triangle;
        const Vec3d area_normal = (b - a).cross(c - a) / 2;
        const Vec3d centroid = centroid_of(*triangle);
        node.area_normal += area_normal;
        weighted += area_normal.norm() * centroid;
        area += area_normal.norm();
        least = least.cwiseMin(centroid);
        greatest = greatest.cwiseMax(centroid);
    }
    node.centroid = area > 0 ? Vec3d(weighted / area) : least;
    double squared_radius = 0;
    node.first_moment = Mat3d::Zero();
    for (auto triangle = begin; triangle != end; ++triangle) {
        const auto& [a, b, c] = *triangle;
        node.first_moment +=
            (centroid_of(*triangle) - node.centroid) * ((b - a).cross(c - a) / 2).transpose();
        for (const Vec3d& corner : *triangle)
            squared_radius = std::max(squared_radius, (corner - node.centroid).squaredNorm());
    }
    node.squared_far_distance = far_ratio * far_ratio * squared_radius;
    node.first = first;
    node.count = count;
    const std::size_t index = nodes_.size();
    nodes_.push_back(node);
    if (count <= leaf_size) return;

    int axis = 0;
    (greatest - least).maxCoeff(&axis);
    const std::int32_t half = count / 2;
    std::nth_element(begin, begin + half, end, [axis](const auto& a, const auto& b) {
        return a[0][axis] + a[1][axis] + a[2][axis] < b[0][axis] + b[1][axis] + b[2][axis];
    });
    nodes_[index].count = 0;
    build(first, half);
    nodes_[index].first = static_cast<std::int32_t>(nodes_.size());
    build(first + half, count - half);
}

double WindingNumber::at(const Vec3d& p) const {
    // Halving 2^31 triangles down to leaves leaves at most one pending sibling a level.
    std::array<std::int32_t, 32> pending;
    int pending_count = 0;
    double half_angles = 0;
    double dipoles = 0;
    for (std::int32_t index = 0;;) {
        const Node& node = nodes_[index];
        const Vec3d to_node = node.centroid - p;
        const double squared_distance = to_node.squaredNorm();
        if (squared_distance > node.squared_far_distance) {
            const double moment = node.first_moment.trace() -
                                  3 * to_node.dot(node.first_moment * to_node) / squared_distance;
            dipoles += (node.area_normal.dot(to_node) + moment) /
                       (squared_distance * std::sqrt(squared_distance));
        } else if (node.count == 0) {
            pending[pending_count++] = node.first;
            ++index;
            continue;
        } else {
            half_angles +=
                half_solid_angle(std::span(triangles_).subspan(node.first, node.count), p);
        }
        if (pending_count == 0) break;
        index = pending[--pending_count];
    }
    return half_angles / (2 * std::numbers::pi) + dipoles / (4 * std::numbers::pi);
}

} // namespace isocast
