// SPDX-License-Identifier: MPL-2.0
#include "quadrics/triangle_splats.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

using Vec2d = Eigen::Vector2d;

/// Corners in view space, from the eye.
std::array<Vec3d, 3> in_view(const Triangle& triangle, const PictureSpace& space) {
    std::array<Vec3d, 3> out;
    for (std::size_t k = 0; k < 3; ++k)
        out[k] = space.view_from_world * (triangle.corners_world[k] - space.eye_world);
    return out;
}

/// A margin in every direction; pixels' positions are rounded to a 64th at least.
constexpr double margin_pixels = 1.0 / 16;
/// Corners that lie farther are cut away: as of splats.
constexpr double greatest_pixels = 1 << 17;

/// Each corner as far from the middle of the inscribed circle as moves all sides by the margin.
TriangleCover grown(const std::array<Vec2d, 3>& corners, const Eigen::AlignedBox2d& box) {
    const auto& [a, b, c] = corners;
    const Vec2d lo = box.min().array() - margin_pixels;
    const Vec2d size = box.sizes().array() + 2 * margin_pixels;
    const PixelBox pixels{float(lo.x()), float(lo.x() + size.x()), float(lo.y()),
                          float(lo.y() + size.y())};
    const Vec3d lengths((c - b).norm(), (a - c).norm(), (b - a).norm());
    const Vec2d ab = b - a;
    const Vec2d ac = c - a;
    const double area = std::abs(ab.x() * ac.y() - ab.y() * ac.x()); // twice
    const double scale = 1 + margin_pixels * lengths.sum() / area;
    double reach = 0;
    for (const Vec2d& corner : corners) reach = std::max(reach, corner.cwiseAbs().maxCoeff());
    // Slivers would become longer than the rectangle around them. Not if the area is 0, either.
    if (area * scale * scale < 4 * size.prod() && 2 * scale * reach < greatest_pixels) {
        const Vec2d middle = (a * lengths[0] + b * lengths[1] + c * lengths[2]) / lengths.sum();
        return {middle + scale * (a - middle), scale * ab, scale * ac, pixels};
    }
    return {lo, {2 * size.x(), 0}, {0, 2 * size.y()}, pixels};
}

/// A point of the picture as (x, y, 1) times its depth: behind the eye, too.
using Pixel = Vec3d;

/// The box of the part of the polygon that is within the picture; empty if none is. A cut is a
/// weighted mean of two ends, by how far inside one and outside the other lies.
Eigen::AlignedBox2d clipped(std::vector<Pixel> polygon, const SplatView& view) {
    const std::array<Vec3d, 4> sides{Vec3d(1, 0, 1), Vec3d(-1, 0, view.width + 1.0), Vec3d(0, 1, 1),
                                     Vec3d(0, -1, view.height + 1.0)};
    for (const Vec3d& side : sides) {
        std::vector<Pixel> inside;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Pixel& p = polygon[i];
            const Pixel& q = polygon[(i + 1) % polygon.size()];
            const double of_p = side.dot(p);
            const double of_q = side.dot(q);
            if (of_p >= 0) inside.push_back(p);
            if ((of_p < 0) != (of_q < 0))
                inside.push_back((p * std::abs(of_q) + q * std::abs(of_p)) /
                                 (std::abs(of_p) + std::abs(of_q)));
        }
        polygon = std::move(inside);
    }
    Eigen::AlignedBox2d box;
    for (const Pixel& p : polygon) {
        // At the eye it is anywhere.
        if (!(p.z() > 0)) return {Vec2d(-1, -1), Vec2d(view.width + 1.0, view.height + 1.0)};
        box.extend(Vec2d(p.head<2>() / p.z()));
    }
    return box;
}

/// Whether a pixel's middle lies within the margin, as far as that is worth finding out.
///
/// corners  not if the triangle was cut
bool has_middles(const std::optional<std::array<Vec2d, 3>>& corners, const Eigen::AlignedBox2d& box,
                 const SplatView& view) {
    const Vec2d first = (box.min().array() - margin_pixels - 0.5).ceil().max(0);
    const Vec2d last = (box.max().array() + margin_pixels - 0.5)
                           .floor()
                           .min(Eigen::Array2d(view.width - 1, view.height - 1));
    if ((first.array() > last.array()).any()) return false;
    constexpr double few = 8; // pixels take longer to draw than these to test
    if (!corners || (last - first + Vec2d::Ones()).prod() > few) return true;
    std::array<Vec2d, 3> inwards; // unit, across the edges
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2d edge = ((*corners)[(k + 1) % 3] - (*corners)[k]).stableNormalized();
        inwards[k] = Vec2d(-edge.y(), edge.x());
        if (inwards[k].dot((*corners)[(k + 2) % 3] - (*corners)[k]) < 0) inwards[k] *= -1;
    }
    for (double y = first.y(); y <= last.y(); ++y)
        for (double x = first.x(); x <= last.x(); ++x) {
            bool is_near = true;
            for (std::size_t k = 0; k < 3; ++k)
                is_near &= inwards[k].dot(Vec2d(x + 0.5, y + 0.5) - (*corners)[k]) > -margin_pixels;
            if (is_near) return true;
        }
    return false;
}

} // namespace

std::optional<TriangleCover> cover_of(const Triangle& triangle, const SplatView& view) {
    if (area_normal(triangle).isZero(0)) return std::nullopt;
    std::array<Pixel, 3> pixels;
    for (std::size_t k = 0; const Vec3d& p : in_view(triangle, view.space)) {
        const double depth = view.space.is_perspective ? -p.z() : 1;
        pixels[k++] << view.pixels_per_unit * p.head<2>() + view.middle_pixels * depth, depth;
    }
    std::array<Vec2d, 3> corners;
    Eigen::AlignedBox2d box;
    bool is_cut = false;
    for (std::size_t k = 0; k < 3; ++k) {
        is_cut |= !(pixels[k].z() > 0);
        corners[k] = pixels[k].head<2>() / pixels[k].z();
        is_cut |= !(corners[k].cwiseAbs().maxCoeff() < greatest_pixels);
        box.extend(corners[k]);
    }
    if (is_cut) box = clipped({pixels.begin(), pixels.end()}, view);
    if (box.isEmpty()) return std::nullopt;
    if (!has_middles(is_cut ? std::nullopt : std::optional(corners), box, view))
        return std::nullopt;
    if (!is_cut) return grown(corners, box);
    // Its corners as one point: no area, hence the rectangle.
    return grown({box.min(), box.min(), box.min()}, box);
}

TriangleRay ray_of(const Triangle& triangle, const PictureSpace& space) {
    const std::array<Vec3d, 3> corners = in_view(triangle, space);
    TriangleRay ray;
    ray.normal = space.view_from_world * area_normal(triangle).stableNormalized();
    ray.offset_world = ray.normal.dot(corners[0]);
    std::array<Vec3d, 3> seen = corners;
    if (!space.is_perspective)
        for (Vec3d& corner : seen) corner.z() = -1;
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        // By their difference: far away corners alone are nearly parallel.
        const Vec3d& a = seen[(k + 1) % 3];
        ray.edges[k] = a.cross(seen[(k + 2) % 3] - a);
        longest = std::max(longest, ray.edges[k].norm());
    }
    for (Vec3d& edge : ray.edges) edge /= longest;
    const auto [farthest, nearest] = std::minmax({corners[0].z(), corners[1].z(), corners[2].z()});
    ray.nearest_world = -nearest;
    ray.farthest_world = -farthest;
    return ray;
}

void append_splats(const TriangleMesh& mesh, const MeshNumbers& numbers, const SplatView& view,
                   Splats& splats) {
    constexpr std::size_t block = 4096; // triangles, that one thread writes down
    struct Written {
        std::vector<float> records;
        std::vector<PixelBox> boxes;
    };
    std::vector<Written> blocks((mesh.triangles.size() + block - 1) / block);
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
        Written& out = blocks[b];
        const auto put = [&out](const Vec3d& v, double w) {
            for (const double value : {v.x(), v.y(), v.z(), w})
                out.records.push_back(static_cast<float>(value));
        };
        const std::size_t end = std::min((b + 1) * block, mesh.triangles.size());
        for (std::size_t i = b * block; i < end; ++i) {
            const Triangle triangle = triangle_of(mesh, i);
            if (is_cut_away(triangle, view.planes)) continue;
            const auto cover = cover_of(triangle, view);
            if (!cover) continue;
            const TriangleRay ray = ray_of(triangle, view.space);
            out.boxes.push_back(cover->box);
            put({cover->corner.x(), cover->corner.y(), cover->side_a.x()}, cover->side_a.y());
            put({cover->side_b.x(), cover->side_b.y(), double(numbers.mesh)},
                double(numbers.first_triangle + i));
            put(ray.edges[0], ray.nearest_world);
            put(ray.edges[1], ray.farthest_world);
            put(ray.edges[2], 0);
            put(ray.normal, ray.offset_world);
        }
    });
    std::vector<float>& records = splats.records[static_cast<std::size_t>(SplatKind::Triangle)];
    std::size_t float_count = records.size();
    for (const Written& written : blocks) float_count += written.records.size();
    records.reserve(float_count);
    for (Written& written : blocks) {
        records.insert(records.end(), written.records.begin(), written.records.end());
        splats.boxes.insert(splats.boxes.end(), written.boxes.begin(), written.boxes.end());
        written = {};
    }
}

} // namespace isocast
