// Closest points of a triangle by a guess of the closest feature.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/prepared_triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

// Ratio of height to length below which the frame is not used. The normal's rounding is about
// 1e-16 over this ratio, so that at 1000 lengths from it a triangle's distance is good to 1e-10.
constexpr double sliver_ratio = 1e-3;

// From anywhere the closest feature is seldom farther.
constexpr int greatest_steps = 4;

} // namespace

PreparedTriangle::PreparedTriangle(const std::array<Vec3d, 3>& of_corners) : corners(of_corners) {
    double squared_longest = 0;
    for (int k = 0; k < 3; ++k) {
        edges[k] = corners[(k + 1) % 3] - corners[k];
        squared_longest = std::max(squared_longest, edges[k].squaredNorm());
    }
    normal = edges[0].cross(edges[1]);
    const double area = normal.norm();
    // No comparison with a number that is none holds, so that face and edges are always rejected.
    const double scale =
        area > sliver_ratio * squared_longest ? 1 / area : std::numeric_limits<double>::quiet_NaN();
    normal *= scale;
    for (int k = 0; k < 3; ++k) inward[k] = normal.cross(edges[k]) / edges[k].norm();
    height_above_edge1 = -inward[1].dot(edges[0]);
}

ClosestPoint closest_point(const Vec3d& p, const PreparedTriangle& triangle, Feature guess) {
    const auto& [corners, edges, normal, inward, height_above_edge1] = triangle;
    constexpr int first_edge = static_cast<int>(Feature::Edge01);
    constexpr int first_vertex = static_cast<int>(Feature::Vertex0);
    const auto edge_feature = [](int k) { return static_cast<Feature>(first_edge + k % 3); };
    const auto vertex_feature = [](int k) { return static_cast<Feature>(first_vertex + k % 3); };
    for (int step = 0; step < greatest_steps; ++step) {
        if (guess == Feature::Face) {
            const Vec3d w = p - corners[0];
            if (!(inward[0].dot(w) > 0)) {
                guess = Feature::Edge01;
            } else if (!(inward[2].dot(w) > 0)) {
                guess = Feature::Edge20;
            } else if (!(inward[1].dot(w) + height_above_edge1 > 0)) {
                guess = Feature::Edge12;
            } else {
                const double height = normal.dot(w);
                return {p - height * normal, height * height, Feature::Face};
            }
        } else if (guess < Feature::Vertex0) {
            const int k = static_cast<int>(guess) - first_edge;
            const Vec3d w = p - corners[k];
            const double along = w.dot(edges[k]);
            const double squared_length = edges[k].squaredNorm();
            if (along <= 0) {
                guess = vertex_feature(k);
            } else if (along >= squared_length) {
                guess = vertex_feature(k + 1);
            } else if (!(inward[k].dot(w) <= 0)) {
                guess = Feature::Face;
            } else {
                const Vec3d foot = corners[k] + edges[k] * (along / squared_length);
                return {foot, (p - foot).squaredNorm(), guess};
            }
        } else {
            const int k = static_cast<int>(guess) - first_vertex;
            const Vec3d w = p - corners[k];
            if (w.dot(edges[k]) > 0)
                guess = edge_feature(k);
            else if (w.dot(edges[(k + 2) % 3]) < 0)
                guess = edge_feature(k + 2);
            else
                return {corners[k], w.squaredNorm(), guess};
        }
    }
    return closest_point(p, corners);
}

} // namespace isocast
