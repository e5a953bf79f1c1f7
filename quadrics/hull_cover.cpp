// SPDX-License-Identifier: MPL-2.0
#include "quadrics/hull_cover.h"

#include <cmath>

namespace isocast {

Pixel pixel_of(const Vec3d& p_world, const SplatView& view) {
    const Vec3d p = view.space.view_from_world * (p_world - view.space.eye_world);
    const double depth = view.space.is_perspective ? -p.z() : 1;
    Pixel pixel;
    pixel << view.pixels_per_unit * p.head<2>() + view.middle_pixels * depth, depth;
    return pixel;
}

/// A cut is a weighted mean of two ends, by how far inside one and outside the other lies.
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
        if (!(p.z() > 0))
            return {Eigen::Vector2d(-1, -1), Eigen::Vector2d(view.width + 1.0, view.height + 1.0)};
        box.extend(Eigen::Vector2d(p.head<2>() / p.z()));
    }
    return box;
}

std::optional<PixelBox> cover_of(const Eigen::AlignedBox2d& box, const SplatView& view) {
    const Eigen::Vector2d lo = (box.min().array() - margin_pixels).max(-1);
    const Eigen::Vector2d hi =
        (box.max().array() + margin_pixels).min(Eigen::Array2d(view.width + 1, view.height + 1));
    const Eigen::Vector2d first = (lo.array() - 0.5).ceil().max(0);
    const Eigen::Vector2d last =
        (hi.array() - 0.5).floor().min(Eigen::Array2d(view.width - 1, view.height - 1));
    if ((first.array() > last.array()).any()) return std::nullopt;
    return PixelBox{float(lo.x()), float(hi.x()), float(lo.y()), float(hi.y())};
}

std::optional<PixelBox> cover_of(std::span<const Vec3d, 4> corners_world, const SplatView& view) {
    std::array<Pixel, 4> pixels;
    bool is_behind = false; // in part
    for (std::size_t k = 0; k < 4; ++k) {
        pixels[k] = pixel_of(corners_world[k], view);
        is_behind |= !(pixels[k].z() > 0);
    }
    Eigen::AlignedBox2d box;
    if (is_behind) { // rays through it leave it by a face
        for (std::size_t k = 0; k < 4; ++k)
            box.extend(clipped({pixels[k], pixels[(k + 1) % 4], pixels[(k + 2) % 4]}, view));
        if (box.isEmpty()) return std::nullopt;
    } else {
        for (const Pixel& p : pixels) box.extend(Eigen::Vector2d(p.head<2>() / p.z()));
    }
    return cover_of(box, view);
}

} // namespace isocast
