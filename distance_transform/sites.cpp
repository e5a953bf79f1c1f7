// The Voronoi sites of a mesh: towers, wedges and cones.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/sites.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace isocast {

namespace {

static_assert(sizeof(Vec3d) == sizeof(double[3]) &&
              sizeof(std::array<int, 3>) == sizeof(std::int32_t[3]));

using Vector = Eigen::Map<const Vec3d>;

/// Calls work(begin, end) for parts of 0 … count - 1.
template<class Work>
void for_parts(std::size_t count, const Work& work) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1024), [&](const auto& range) {
        work(static_cast<std::int32_t>(range.begin()), static_cast<std::int32_t>(range.end()));
    });
}

constexpr std::size_t most_clipping_planes = 12;

/// The greatest |l| with l·u_j <= sign * k_j for all j, 0 if there is no such l. planes  (u_j,
/// k_j); leaving some out, or a `bound` of |l| that is too large, makes the result larger at most.
double greatest_offset(std::span<const Eigen::Vector3d> planes, double bound, double sign) {
    using Point = Eigen::Vector2d;
    // A convex polygon gains one corner at most from a cut.
    std::array<Point, most_clipping_planes + 4> polygon = {
        Point(-bound, -bound), Point(bound, -bound), Point(bound, bound), Point(-bound, bound)};
    std::array<Point, most_clipping_planes + 4> cut;
    std::size_t count = 4;
    const double slack = 1e-6 * bound; // rounding must not close a thin cone
    for (const Eigen::Vector3d& plane : planes) {
        std::size_t cut_count = 0;
        const auto excess = [&](const Point& p) {
            return p.dot(plane.head<2>()) - sign * plane.z() - slack;
        };
        for (std::size_t i = 0; i < count; ++i) {
            const Point& p = polygon[i];
            const Point& q = polygon[(i + 1) % count];
            const double at_p = excess(p);
            const double at_q = excess(q);
            if (at_p <= 0) cut[cut_count++] = p;
            if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0))
                cut[cut_count++] = p + (q - p) * (at_p / (at_p - at_q));
        }
        std::swap(polygon, cut);
        count = cut_count;
        if (count == 0) return 0;
    }
    double greatest = 0;
    for (std::size_t i = 0; i < count; ++i) greatest = std::max(greatest, polygon[i].norm());
    return greatest;
}

} // namespace

Sites::Sites(const Mesh& mesh, const MeshTopology& topology, double half_width_voxels,
             InstructionSet instruction_set)
    : kernels_(scan_kernels(instruction_set)), faces_(mesh.triangles.size()),
      edges_(topology.edge_count()), fans_(static_cast<std::size_t>(topology.fan_count)) {
    arrays_.vertices = reinterpret_cast<const double(*)[3]>(mesh.vertices_world.data());
    arrays_.triangles = reinterpret_cast<const std::int32_t(*)[3]>(mesh.triangles.data());
    arrays_.half_width = half_width_voxels;
    arrays_.faces = faces_.data();
    arrays_.edges = edges_.data();
    arrays_.fans = fans_.data();
    arrays_.face_count = static_cast<std::int32_t>(faces_.size());
    arrays_.edge_count = static_cast<std::int32_t>(edges_.size());
    arrays_.fan_count = static_cast<std::int32_t>(fans_.size());
    for_parts(faces_.size(), [&](std::int32_t begin, std::int32_t end) {
        kernels_.find_normals(arrays_, begin, end, faces_.data());
    });
    find_edges(mesh, topology);

    std::vector<char> is_open(fans_.size());
    for (std::size_t e = 0; e < edges_.size(); ++e) {
        if (edges_[e].kind != EdgeData::Border && edges_[e].kind != EdgeData::Junction) continue;
        for (const std::uint32_t h : topology.edge(e)) {
            is_open[topology.fan_of_corner[h]] = 1;
            is_open[topology.fan_of_corner[h / 3 * 3 + (h % 3 + 1) % 3]] = 1;
        }
    }
    for_parts(fans_.size(), [&](std::int32_t begin, std::int32_t end) {
        kernels_.find_fans(arrays_, topology.fan_corners.data(), topology.fan_begin.data(),
                           is_open.data(), begin, end, fans_.data());
    });
    narrow_fans(mesh, topology);
}

void Sites::find_edges(const Mesh& mesh, const MeshTopology& topology) {
    for_parts(edges_.size(), [&](std::int32_t begin, std::int32_t end) {
        for (std::int32_t e = begin; e < end; ++e) {
            const auto halfedges = topology.edge(static_cast<std::size_t>(e));
            EdgeData& edge = edges_[e];
            edge.ends[0] = halfedge_from(mesh, halfedges[0]);
            edge.ends[1] = halfedge_to(mesh, halfedges[0]);
            edge.faces[0] = static_cast<std::int32_t>(halfedges[0] / 3);
            edge.kind = EdgeData::Border;
            if (halfedges.size() == 1) continue;
            edge.faces[1] = static_cast<std::int32_t>(halfedges[1] / 3);
            edge.kind = halfedges.size() > 2                                ? EdgeData::Junction
                        : halfedge_from(mesh, halfedges[1]) == edge.ends[0] ? EdgeData::Parallel
                                                                            : EdgeData::Opposed;
        }
    });
    for (std::size_t e = 0; e < edges_.size(); ++e) {
        if (edges_[e].kind != EdgeData::Junction) continue;
        Vec3d sum = Vec3d::Zero();
        for (const std::uint32_t h : topology.edge(e)) sum += Vector(faces_[h / 3].normal);
        edges_[e].faces[0] = static_cast<std::int32_t>(junctions_.size());
        junctions_.push_back(sum);
    }
    arrays_.junctions = reinterpret_cast<const double(*)[3]>(junctions_.data());
}

/// Cones of saddles are mostly empty; where they would be wide, that is worth finding out.
void Sites::narrow_fans(const Mesh& mesh, const MeshTopology& topology) {
    for_parts(fans_.size(), [&](std::int32_t begin, std::int32_t end) {
        for (std::int32_t f = begin; f < end; ++f) {
            FanData& fan = fans_[f];
            if (std::max(fan.slope_above, fan.slope_below) * arrays_.half_width <= 0.5) continue;
            const Vec3d n = Vector(fan.normal).stableNormalized();
            const Vec3d right = n.unitOrthogonal();
            const Vec3d forward = n.cross(right);
            std::array<Eigen::Vector3d, most_clipping_planes> planes; // u_j across n, k_j
            std::size_t count = 0;
            for (const std::uint32_t c : topology.fan(static_cast<std::size_t>(f))) {
                if (count == planes.size()) break;
                const auto& triangle = mesh.triangles[c / 3];
                const Vec3d edge = mesh.vertices_world[triangle[(c + 1) % 3]] -
                                   mesh.vertices_world[triangle[c % 3]];
                const double up = edge.dot(n);
                const Vec3d flat = edge - up * n;
                planes[count++] =
                    Eigen::Vector3d(flat.dot(right), flat.dot(forward), -up) / flat.norm();
            }
            const auto known = std::span(planes).first(count);
            fan.slope_above = std::min(fan.slope_above, greatest_offset(known, fan.slope_above, 1));
            fan.slope_below =
                std::min(fan.slope_below, greatest_offset(known, fan.slope_below, -1));
        }
    });
}

Vec3d Sites::nearest_point(std::int32_t site, const Vec3d& p) const {
    const auto vertex = [&](std::int32_t v) { return Vector(arrays_.vertices[v]); };
    if (site < arrays_.face_count) {
        const Vector normal(faces_[site].normal);
        return p - normal.dot(p - vertex(arrays_.triangles[site][0])) * normal;
    }
    if (const std::int32_t e = site - arrays_.face_count; e < arrays_.edge_count) {
        const Vec3d from = vertex(edges_[e].ends[0]);
        const Vec3d along = (vertex(edges_[e].ends[1]) - from).normalized();
        return from + along.dot(p - from) * along;
    }
    return vertex(fans_[site - arrays_.face_count - arrays_.edge_count].vertex);
}

std::int32_t Sites::feature(std::int32_t site) const {
    const std::int32_t first_fan = arrays_.face_count + arrays_.edge_count;
    return site < first_fan ? site : first_fan + fans_[site - first_fan].vertex;
}

} // namespace isocast
