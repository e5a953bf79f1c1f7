// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim_mesh.h"

#include "volume/errors.h"

#include <Eigen/Geometry>

#include <numbers>

namespace isocast {

namespace {

struct Edge {
    int from, to; // from < to
    int triangle;
    int k;
    bool is_turned;
};

} // namespace

SlimMesh::SlimMesh(const TriangleMesh& mesh, double crease_degrees) {
    check(std::span(&mesh, 1));
    vertices_world_ = mesh.vertices_world;
    Eigen::AlignedBox3d box;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle triangle = triangle_of(mesh, i);
        const Vec3d normal = area_normal(triangle);
        if (normal.isZero(0)) continue;
        triangles_.push_back(mesh.triangles[i]);
        normals_.push_back(normal.stableNormalized());
        for (const Vec3d& corner : triangle.corners_world) box.extend(corner);
    }
    if (triangles_.empty()) throw InputError("no triangle of the mesh has an area");
    diagonal_world_ = box.diagonal().norm();
    meet(crease_degrees);
    bend();
}

void SlimMesh::meet(double crease_degrees) {
    std::vector<Edge> edges;
    for (std::size_t i = 0; i < triangles_.size(); ++i)
        for (int k = 0; k < 3; ++k) {
            const int a = triangles_[i][static_cast<std::size_t>(k)];
            const int b = triangles_[i][static_cast<std::size_t>((k + 1) % 3)];
            edges.push_back({std::min(a, b), std::max(a, b), static_cast<int>(i), k, a > b});
        }
    std::ranges::sort(edges, {}, [](const Edge& e) {
        return std::array{e.from, e.to, e.triangle, e.k};
    });
    sides_.resize(triangles_.size());
    const double least = std::cos(crease_degrees * std::numbers::pi / 180);
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i + 1;
        while (end < edges.size() && edges[end].from == edges[i].from &&
               edges[end].to == edges[i].to)
            ++end;
        const Edge& one = edges[i];
        if (end - i == 2 && one.is_turned != edges[i + 1].is_turned) {
            const Edge& other = edges[i + 1];
            const auto a = static_cast<std::size_t>(one.triangle);
            const auto b = static_cast<std::size_t>(other.triangle);
            const bool is_crease = normals_[a].dot(normals_[b]) < least;
            sides_[a][static_cast<std::size_t>(one.k)] = {other.triangle, is_crease};
            sides_[b][static_cast<std::size_t>(other.k)] = {one.triangle, is_crease};
        } else {
            is_closed_ = false;
        }
        i = end;
    }
}

Vec3d SlimMesh::corner_normal(std::size_t i, std::size_t k) const {
    const auto weighted = [&](std::size_t t, std::size_t corner) {
        const Vec3d& p = vertex(triangles_[t][corner]);
        const Vec3d a = vertex(triangles_[t][(corner + 1) % 3]) - p;
        const Vec3d b = vertex(triangles_[t][(corner + 2) % 3]) - p;
        return Vec3d(std::atan2(a.cross(b).norm(), a.dot(b)) * normals_[t]);
    };
    Vec3d sum = weighted(i, k);
    for (const bool is_left : {true, false}) {
        std::size_t t = i;
        std::size_t corner = k;
        for (;;) {
            const Side& side = sides_[t][is_left ? (corner + 2) % 3 : corner];
            if (side.neighbour < 0 || side.is_crease) break;
            const int v = triangles_[t][corner];
            t = static_cast<std::size_t>(side.neighbour);
            if (t == i) return sum.stableNormalized(); // all around
            corner = static_cast<std::size_t>(std::ranges::find(triangles_[t], v) -
                                              triangles_[t].begin());
            sum += weighted(t, corner);
        }
    }
    return sum.stableNormalized();
}

void SlimMesh::bend() {
    std::vector<std::array<Vec3d, 3>> corner_normals(size());
    for (std::size_t i = 0; i < size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) corner_normals[i][k] = corner_normal(i, k);
    bows_.resize(size());
    longest_world_.resize(size());
    vertex_areas_.resize(vertices_world_.size());
    for (std::size_t i = 0; i < size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d d = vertex(triangles_[i][(k + 1) % 3]) - vertex(triangles_[i][k]);
            longest_world_[i] = std::max(longest_world_[i], d.norm());
            const Vec3d e = vertex(triangles_[i][(k + 2) % 3]) - vertex(triangles_[i][k]);
            vertex_areas_[static_cast<std::size_t>(triangles_[i][k])] += d.cross(e).norm() / 6;
            // (bow asked for, along which unit direction), of a face whose corner `from` is here.
            const auto asked = [&](std::size_t t, std::size_t from, std::size_t to) {
                const Vec3d& a = corner_normals[t][from];
                const Vec3d& b = corner_normals[t][to];
                return std::pair((b - a).dot(d) / 8, Vec3d((a + b).stableNormalized()));
            };
            const auto [bow, n] = asked(i, k, (k + 1) % 3);
            const Side& side = sides_[i][k];
            bows_[i][k] = bow * n;
            if (side.neighbour < 0 || !side.is_crease) continue;
            const auto other = static_cast<std::size_t>(side.neighbour);
            const auto at = [&](int v) {
                return static_cast<std::size_t>(std::ranges::find(triangles_[other], v) -
                                                triangles_[other].begin());
            };
            const auto [bow2, n2] =
                asked(other, at(triangles_[i][k]), at(triangles_[i][(k + 1) % 3]));
            // The least vector with both parts.
            const double cosine = n.dot(n2);
            const double sine2 = 1 - cosine * cosine;
            // 0.03: sin^2 of 10 degrees; what lies back to back asks for anything.
            bows_[i][k] =
                sine2 < 0.03
                    ? Vec3d(Vec3d::Zero())
                    : Vec3d(((bow - cosine * bow2) * n + (bow2 - cosine * bow) * n2) / sine2);
        }
}

Vec3d SlimMesh::point(std::size_t i, const Vec3d& l) const {
    Vec3d p = Vec3d::Zero();
    for (int k = 0; k < 3; ++k) {
        const auto corner = static_cast<std::size_t>(k);
        p += l[k] * vertex(triangles_[i][corner]) + 4 * l[k] * l[(k + 1) % 3] * bows_[i][corner];
    }
    return p;
}

} // namespace isocast
