// A triangle in its own orthonormal frame, and the closest feature found in it.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/triangle_frame.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

Eigen::Map<const Vec3d> vector(const double (&v)[3]) {
    return Eigen::Map<const Vec3d>(v);
}

TriangleFrame::Side side(double base, double h) {
    const double length = std::hypot(base, h);
    // Without length the side is the apex itself, at a right angle to the longest side.
    if (!(length > 0)) return {base, 0, 1, 0};
    return {base, base / length, h / length, length};
}

} // namespace

TriangleFrame triangle_frame(const std::array<Vec3d, 3>& corners) {
    TriangleFrame frame;
    frame.first_corner = 0;
    double squared_length = -1;
    for (int k = 0; k < 3; ++k) {
        const double candidate = (corners[(k + 1) % 3] - corners[k]).squaredNorm();
        if (candidate <= squared_length) continue;
        squared_length = candidate;
        frame.first_corner = k;
    }
    const Vec3d& first = corners[frame.first_corner];
    const Vec3d& apex = corners[(frame.first_corner + 2) % 3];
    const double length = std::sqrt(squared_length);
    const Vec3d r = length > 0 ? Vec3d((corners[(frame.first_corner + 1) % 3] - first) / length)
                               : Vec3d::UnitX();
    // The foot lies between the ends, but for rounding.
    const double left = std::clamp((apex - first).dot(r), 0.0, length);
    const Vec3d origin = first + left * r;
    // Twice orthogonalised: what is left of a sliver's height after the first time may still lean.
    Vec3d s = apex - origin;
    s -= s.dot(r) * r;
    const double h = s.norm();
    // Below 1e-300 a division by the height would not be finite.
    s = h > 1e-300 ? Vec3d(s / h) : r.unitOrthogonal();
    s = (s - s.dot(r) * r).normalized();
    Eigen::Map<Vec3d>(frame.origin) = origin;
    Eigen::Map<Vec3d>(frame.r) = r;
    Eigen::Map<Vec3d>(frame.s) = s;
    Eigen::Map<Vec3d>(frame.t) = r.cross(s);
    frame.h = h;
    frame.right = side(length - left, h);
    frame.left = side(left, h);
    return frame;
}

std::vector<TriangleFrame> triangle_frames(const Mesh& mesh) {
    std::vector<TriangleFrame> frames(mesh.triangles.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, frames.size(), 1024), [&](auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const auto [a, b, c] = mesh.triangles[i];
            frames[i] = triangle_frame(
                {mesh.vertices_world[a], mesh.vertices_world[b], mesh.vertices_world[c]});
        }
    });
    return frames;
}

LocalClosest closest_feature(const TriangleFrame& frame, const Vec3d& p) {
    constexpr std::array edges = {Feature::Edge01, Feature::Edge12, Feature::Edge20};
    constexpr std::array vertices = {Feature::Vertex0, Feature::Vertex1, Feature::Vertex2};
    const Vec3d offset = p - vector(frame.origin);
    const double r = offset.dot(vector(frame.r));
    const double s = offset.dot(vector(frame.s));
    const double t = offset.dot(vector(frame.t));
    const bool is_left = r < 0;
    const TriangleFrame::Side& side = is_left ? frame.left : frame.right;
    const int foot = is_left ? frame.first_corner : (frame.first_corner + 1) % 3;
    const int apex = (frame.first_corner + 2) % 3;
    const double beyond = std::abs(r) - side.base;
    const double u = s * side.sine - beyond * side.cosine;
    const double v = beyond * side.sine + s * side.cosine;
    double planar_r = 0;
    double planar_s = 0;
    Feature feature = Feature::Face;
    if (s < 0) {
        planar_r = std::max(beyond, 0.0);
        planar_s = s;
        feature = beyond > 0 ? vertices[foot] : edges[frame.first_corner];
    } else if (v > 0) {
        const double along = u - std::clamp(u, 0.0, side.length);
        planar_r = v * side.sine - along * side.cosine;
        planar_s = v * side.cosine + along * side.sine;
        feature = u <= 0             ? vertices[foot]
                  : u >= side.length ? vertices[apex]
                                     : edges[is_left ? apex : foot];
    }
    if (is_left) planar_r = -planar_r;
    return {planar_r * vector(frame.r) + planar_s * vector(frame.s) + t * vector(frame.t), feature};
}

} // namespace isocast
