// The thesis's bounding polyhedra: bisector planes, the covering test, and the closing of gaps.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/prism.h"

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

// Sine of an angle below which rounding decides it: as for flat edges (one_rings.cpp).
constexpr double angle_slack = 1e-10;

} // namespace

Prisms::Prisms(const Mesh& mesh, double half_width, Gaps gaps)
    : mesh_(mesh), half_width_(half_width), rings_(one_rings(mesh)),
      lateral_normals_(rings_.twins.size()), shifts_(rings_.twins.size(), 0) {
    for (int h = 0; h < static_cast<int>(rings_.twins.size()); ++h) {
        const int twin = rings_.twins[h];
        if (twin >= 0 && twin < h) {
            lateral_normals_[h] = -lateral_normals_[twin];
            continue;
        }
        const std::array<int, 3>& corners = mesh.triangles[h / 3];
        const Vec3d along =
            mesh.vertices_world[corners[(h + 1) % 3]] - mesh.vertices_world[corners[h % 3]];
        const Vec3d& normal = rings_.face_normals[h / 3];
        // The plane holds the edge and the mean of both normals. Coplanar neighbours need no case
        // of their own; of two faces folded onto each other the faces' own plane is the bisector.
        const Vec3d both = twin < 0 ? normal : Vec3d(normal + rings_.face_normals[twin / 3]);
        lateral_normals_[h] =
            both.norm() > angle_slack ? along.cross(both).stableNormalized() : Vec3d(-normal);
    }
    counts_.vertices = static_cast<int>(rings_.count());
    for (std::size_t i = 0; i < rings_.count(); ++i) {
        counts_.saddles += rings_.kind(i) == VertexKind::Saddle ? 1 : 0;
        const std::vector<Vec3d> failing = failing_test_points(i);
        if (failing.empty()) continue;
        ++counts_.gaps;
        if (gaps == Gaps::Close) close_gap(i, failing);
    }
}

std::array<HalfSpace, 5> Prisms::half_spaces(int triangle) const {
    std::array<HalfSpace, 5> result;
    for (int k = 0; k < 3; ++k) {
        const Vec3d& normal = lateral_normals_[3 * triangle + k];
        const Vec3d& on_plane = mesh_.vertices_world[mesh_.triangles[triangle][k]];
        result[k] = {normal, normal.dot(on_plane) + shifts_[3 * triangle + k]};
    }
    const Vec3d& normal = rings_.face_normals[triangle];
    const double height = normal.dot(mesh_.vertices_world[mesh_.triangles[triangle][0]]);
    result[3] = {normal, height + half_width_};
    result[4] = {-normal, half_width_ - height};
    return result;
}

std::vector<Vec3d> Prisms::bisectors(std::size_t ring) const {
    std::vector<Vec3d> normals;
    for (const int corner : rings_.ring(ring)) normals.push_back(-lateral_normals_[corner]);
    return normals;
}

/// The covering test: a point near the vertex is in P_i if it is right of A_i and left of A_i+1, so
/// it is in none only if it is right of all planes, or left of all. Returns unit vectors from the
/// vertex that are right of all, one on each line A_i ∩ A_i+1 that fails; by point symmetry their
/// opposites fail too.
std::vector<Vec3d> Prisms::failing_test_points(std::size_t ring) const {
    std::vector<Vec3d> failing;
    if (!rings_.is_closed(ring)) return failing;
    const std::vector<Vec3d> planes = bisectors(ring);
    const std::size_t n = planes.size();
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t next = (i + 1) % n;
        const Vec3d line = planes[i].cross(planes[next]);
        const double sine = line.norm();
        if (sine <= angle_slack) continue; // one plane, not two: every point of it passes
        const Vec3d point = line / sine;
        // The line is as uncertain as the planes are, divided by the angle between them.
        const double slack = angle_slack / sine;
        bool is_left_once = false;
        bool is_right_once = false;
        for (std::size_t j = 0; j < n && !(is_left_once && is_right_once); ++j) {
            if (j == i || j == next) continue;
            const double side = planes[j].dot(point);
            is_left_once |= side <= slack;
            is_right_once |= side >= -slack;
        }
        if (is_left_once && is_right_once) continue;
        failing.push_back(is_right_once ? point : Vec3d(-point));
    }
    return failing;
}

/// Shifts the planes around the vertex outward, parallel, until each prism there holds the centroid
/// of the test points and its opposite.
///
/// The thesis does not say where on their lines the test points lie. We put the centroid at
/// distance half width: what is right of all planes shifted through g is g + the gap's cone, and
/// that has no point nearer than g if the cone lies within 90 degrees of g. So no gap is left
/// within the half width of the vertex.
void Prisms::close_gap(std::size_t ring, const std::vector<Vec3d>& test_points) {
    Vec3d centroid = Vec3d::Zero();
    for (const Vec3d& point : test_points) centroid += point;
    centroid = half_width_ * centroid.normalized();
    for (const int corner : rings_.ring(ring)) {
        const double shift = std::abs(lateral_normals_[corner].dot(centroid));
        for (const int halfedge : {corner, rings_.twins[corner]})
            shifts_[halfedge] = std::max(shifts_[halfedge], shift);
    }
}

namespace {

/// The triangle cut out of the plane normal · p = height by three half-spaces.
std::array<Vec3d, 3> cross_section(const std::array<HalfSpace, 5>& prism, double height) {
    std::array<Vec3d, 3> corners;
    for (int k = 0; k < 3; ++k) {
        const HalfSpace& before = prism[(k + 2) % 3];
        Mat3d planes;
        planes << before.normal.transpose(), prism[k].normal.transpose(),
            prism[3].normal.transpose();
        corners[k] =
            planes.colPivHouseholderQr().solve(Vec3d(before.offset, prism[k].offset, height));
    }
    return corners;
}

} // namespace

Mesh prism_mesh(const Mesh& mesh, const Prisms& prisms, std::span<const int> triangles) {
    Mesh result;
    const auto add_triangle = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        const int first = static_cast<int>(result.vertices_world.size());
        result.vertices_world.insert(result.vertices_world.end(), {a, b, c});
        result.triangles.push_back({first, first + 1, first + 2});
    };
    for (const int t : triangles) {
        const std::array<HalfSpace, 5> prism = prisms.half_spaces(t);
        // All cross sections are similar, and their size is linear in the height: where one of the
        // two end faces would be turned inside out, the prism ends in a point before.
        const auto size_at = [&](const std::array<Vec3d, 3>& s) {
            const Vec3d edge = mesh.vertices_world[mesh.triangles[t][1]] -
                               mesh.vertices_world[mesh.triangles[t][0]];
            return (s[1] - s[0]).dot(edge);
        };
        std::array<Vec3d, 3> top = cross_section(prism, prism[3].offset);
        std::array<Vec3d, 3> bottom = cross_section(prism, -prism[4].offset);
        const double top_size = size_at(top);
        const double bottom_size = size_at(bottom);
        const Vec3d apex = top[0] + (bottom[0] - top[0]) * (top_size / (top_size - bottom_size));
        if (top_size <= 0) top.fill(apex);
        if (bottom_size <= 0) bottom.fill(apex);
        if (top_size > 0) add_triangle(top[0], top[1], top[2]);
        if (bottom_size > 0) add_triangle(bottom[0], bottom[2], bottom[1]);
        for (int k = 0; k < 3; ++k) {
            const int next = (k + 1) % 3;
            if (bottom_size > 0) add_triangle(bottom[k], bottom[next], top[next]);
            if (top_size > 0) add_triangle(bottom[k], top[next], top[k]);
        }
    }
    return result;
}

} // namespace isocast
