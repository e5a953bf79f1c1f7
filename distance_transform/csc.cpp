// Characteristics/Scan-Conversion: each site's polyhedron is scanned, the least distance kept.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/csc.h"

#include "distance_transform/band_tiles.h"
#include "distance_transform/convex_scan.h"
#include "distance_transform/one_rings.h"
#include "distance_transform/progress_meter.h"
#include "distance_transform/pseudonormals.h"
#include "volume/errors.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace isocast {

namespace {

HalfSpace half_space(const Vec3d& unit_normal, const Vec3d& on_plane, double shift = 0) {
    return {unit_normal, unit_normal.dot(on_plane) + shift};
}

/// Outlines of the cone that `rays` span about `axis`, as outward normals of planes through its
/// apex: the convex hull of the rays' points in the plane axis · p = 1. Nothing if a ray does not
/// meet that plane.
std::optional<std::vector<Vec3d>> hull_of_rays(const std::vector<Vec3d>& rays, const Vec3d& axis) {
    using Vec2d = Eigen::Vector2d;
    const Vec3d u = axis.unitOrthogonal();
    const Vec3d v = axis.cross(u);
    std::vector<Vec2d> points;
    for (const Vec3d& ray : rays) {
        const double along = ray.dot(axis);
        if (!(along > 0)) return std::nullopt;
        points.emplace_back(ray.dot(u) / along, ray.dot(v) / along);
    }
    std::ranges::sort(points, [](const Vec2d& a, const Vec2d& b) {
        return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
    });
    // Andrew's monotone chains, the lower one from left to right and the upper one back.
    std::vector<Vec2d> hull;
    const auto add_chain = [&hull](auto first, auto last) {
        const std::size_t start = hull.size();
        for (; first != last; ++first) {
            const auto turns_left = [&] {
                const Vec2d a = hull.back() - hull[hull.size() - 2];
                const Vec2d b = *first - hull.back();
                return a.x() * b.y() - a.y() * b.x() > 0;
            };
            while (hull.size() >= start + 2 && !turns_left()) hull.pop_back();
            hull.push_back(*first);
        }
        hull.pop_back(); // the other chain begins with it
    };
    add_chain(points.begin(), points.end());
    add_chain(points.rbegin(), points.rend());

    std::vector<Vec3d> normals;
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const Vec2d along = hull[(i + 1) % hull.size()] - hull[i];
        const Vec2d outward(along.y(), -along.x());
        normals.push_back(
            (outward.x() * u + outward.y() * v - outward.dot(hull[i]) * axis).stableNormalized());
    }
    return normals;
}

class Csc {
public:
    Csc(const LatticeMesh& lattice, double half_width, double memory_bytes)
        : mesh_(lattice.mesh), half_width_(half_width), memory_bytes_(memory_bytes),
          voxel_size_(lattice.space.voxel_size_world()), rings_(one_rings(mesh_)), normals_(mesh_) {
        if (std::ranges::find(rings_.twins, -1) != rings_.twins.end())
            throw InputError("the mesh is not closed, as the thesis's polyhedra need");
    }

    ReferenceBand run(const Progress& progress) {
        const int faces = static_cast<int>(mesh_.triangles.size());
        const int rings = static_cast<int>(rings_.count());
        ProgressMeter meter(progress, "transform", 4.0 * faces + rings, 256);
        for (int t = 0; t < faces; ++t, meter.add(1)) scan_tower(t);
        for (int h = 0; h < 3 * faces; ++h, meter.add(1))
            if (h < rings_.twins[h]) scan_wedge(h);
        for (int i = 0; i < rings; ++i, meter.add(1)) scan_cones(i);

        ReferenceBand result{.distance_evaluations = evaluations_};
        for (const auto& [zyx, distances] : blocks_) {
            FieldBlock block =
                distances.to_block(Index3(zyx[2], zyx[1], zyx[0]), half_width_, voxel_size_);
            if (block.active.any()) result.blocks.push_back(block);
        }
        return result;
    }

private:
    const Vec3d& corner(int halfedge) const {
        return mesh_.vertices_world[mesh_.triangles[halfedge / 3][halfedge % 3]];
    }
    /// Unit, from the corner that names the half-edge to the next.
    Vec3d direction(int halfedge) const {
        const int next = halfedge % 3 == 2 ? halfedge - 2 : halfedge + 1;
        return (corner(next) - corner(halfedge)).stableNormalized();
    }
    /// Unit, in the face's plane, out of the triangle across its half-edge.
    Vec3d out_of_face(int halfedge) const {
        return direction(halfedge).cross(rings_.face_normals[halfedge / 3]).stableNormalized();
    }

    /// Offers distance(p) at every sample of the polyhedron within the half width of `site`'s box.
    template<class Distance>
    void scan(std::span<const HalfSpace> polyhedron, WorldBox site, const Distance& distance) {
        site.min.array() -= half_width_ + scan_slack;
        site.max.array() += half_width_ + scan_slack;
        for (const Index3& block : blocks_meeting(polyhedron, site)) {
            BlockDistances* own = nullptr; // no block is made that has no sample inside
            scan_block(polyhedron, block, [&](const Index3& p, int i) {
                ++evaluations_;
                if (!own) own = &distances_of(block);
                own->offer(i, distance(p.cast<double>()));
            });
        }
    }

    BlockDistances& distances_of(const Index3& block) {
        BlockDistances& own = blocks_[{block.z(), block.y(), block.x()}];
        const std::size_t bytes = blocks_.size() * (sizeof(BlockDistances) + sizeof(FieldBlock));
        if (static_cast<double>(bytes) > memory_bytes_)
            refuse_memory(static_cast<double>(bytes), memory_bytes_);
        return own;
    }

    /// The prism over the triangle, on both sides: distance to its plane.
    void scan_tower(int triangle) {
        const Vec3d& normal = rings_.face_normals[triangle];
        const std::array<Vec3d, 3> corners = {corner(3 * triangle), corner(3 * triangle + 1),
                                              corner(3 * triangle + 2)};
        std::vector<HalfSpace> tower = {half_space(normal, corners[0], half_width_),
                                        half_space(-normal, corners[0], half_width_)};
        for (int k = 0; k < 3; ++k)
            tower.push_back(half_space(out_of_face(3 * triangle + k), corners[k]));
        const WorldBox box{corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]),
                           corners[0].cwiseMax(corners[1]).cwiseMax(corners[2])};
        scan(tower, box, [&](const Vec3d& p) { return normal.dot(p - corners[0]); });
    }

    /// Between the towers on the convex side of an edge: distance to its line.
    void scan_wedge(int halfedge) {
        if (rings_.bends[halfedge] == Bend::Flat) return; // the towers meet
        const int twin = rings_.twins[halfedge];
        const Vec3d& from = corner(halfedge);
        const Vec3d& to = corner(twin);
        const Vec3d along = direction(halfedge);
        const double side = rings_.bends[halfedge] == Bend::Convex ? 1 : -1;
        const Vec3d middle =
            side *
            (rings_.face_normals[halfedge / 3] + rings_.face_normals[twin / 3]).stableNormalized();
        const std::array<HalfSpace, 5> wedge = {
            half_space(-out_of_face(halfedge), from), half_space(-out_of_face(twin), from),
            half_space(middle, from, half_width_), half_space(-along, from), half_space(along, to)};
        scan(wedge, {from.cwiseMin(to), from.cwiseMax(to)},
             [&](const Vec3d& p) { return side * (p - from).cross(along).norm(); });
    }

    /// Between the wedges at a vertex: distance to the vertex.
    void scan_cones(int ring) {
        const auto corners = rings_.ring(ring);
        const Vec3d& apex = corner(corners.front());
        const auto feature =
            static_cast<Feature>(static_cast<int>(Feature::Vertex0) + corners.front() % 3);
        const Vec3d& pseudonormal = normals_.at(corners.front() / 3, feature);
        const auto scan_cone = [&](const std::vector<HalfSpace>& cone) {
            scan(cone, {apex, apex}, [&](const Vec3d& p) {
                const double distance = (p - apex).norm();
                return (p - apex).dot(pseudonormal) < 0 ? -distance : distance;
            });
        };
        Vec3d axis = Vec3d::Zero();
        for (const int c : corners) axis += rings_.face_normals[c / 3];
        axis.stableNormalize();

        const VertexKind kind = rings_.kind(ring);
        if (kind == VertexKind::Flat) return;
        if (kind != VertexKind::Saddle) {
            std::vector<HalfSpace> cone = {
                half_space(kind == VertexKind::Convex ? axis : -axis, apex, half_width_)};
            for (const int c : corners) cone.push_back(half_space(direction(c), apex));
            scan_cone(cone);
            return;
        }
        std::vector<Vec3d> rays;
        for (const int c : corners) rays.push_back(rings_.face_normals[c / 3]);
        const auto outlines = hull_of_rays(rays, axis);
        if (!outlines) {
            scan_cone({});
            return;
        }
        for (const double side : {1.0, -1.0}) {
            std::vector<HalfSpace> cone = {half_space(side * axis, apex, half_width_)};
            for (const Vec3d& normal : *outlines) cone.push_back(half_space(side * normal, apex));
            scan_cone(cone);
        }
    }

    const Mesh& mesh_;
    double half_width_;
    double memory_bytes_;
    double voxel_size_;
    OneRings rings_;
    Pseudonormals normals_;
    std::map<std::array<int, 3>, BlockDistances> blocks_; // by z, y, x
    std::int64_t evaluations_ = 0;
};

} // namespace

ReferenceBand characteristics_scan_conversion(const LatticeMesh& lattice, double half_width_voxels,
                                              double memory_bytes, const Progress& progress) {
    return Csc(lattice, half_width_voxels, memory_bytes).run(progress);
}

} // namespace isocast
