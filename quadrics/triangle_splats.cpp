// SPDX-License-Identifier: MPL-2.0
#include "quadrics/triangle_splats.h"

#include "quadrics/hull_cover.h"

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
    for (std::size_t k = 0; k < 3; ++k) pixels[k] = pixel_of(triangle.corners_world[k], view);
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
    append_in_order(SplatKind::Triangle, mesh.triangles.size(), splats,
                    [&](std::size_t i, float* to) -> std::optional<PixelBox> {
                        const Triangle triangle = triangle_of(mesh, i);
                        if (is_cut_away(triangle, view.planes)) return std::nullopt;
                        const auto cover = cover_of(triangle, view);
                        if (!cover) return std::nullopt;
                        const TriangleRay ray = ray_of(triangle, view.space);
                        Record record(to);
                        record.put({cover->corner.x(), cover->corner.y(), cover->side_a.x(),
                                    cover->side_a.y()});
                        record.put({cover->side_b.x(), cover->side_b.y(), double(numbers.mesh),
                                    double(numbers.first_triangle + i)});
                        record.put(ray.edges[0], ray.nearest_world);
                        record.put(ray.edges[1], ray.farthest_world);
                        record.put(ray.edges[2], 0);
                        record.put(ray.normal, ray.offset_world);
                        return cover->box;
                    });
}

} // namespace isocast
