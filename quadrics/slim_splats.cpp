// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim_splats.h"

#include "quadrics/hull_cover.h"

namespace isocast {

namespace {

/// Between its least and its greatest height over its disc.
Cylinder drum_around(const SlimPatch& patch) {
    const Reach heights = height_range(patch);
    const double spare = 1e-3 * patch.radius_world; // flat ones have an axis, too
    return {.a_world = patch.centre_world + (heights.least - spare) * patch.normal,
            .b_world = patch.centre_world + (heights.greatest + spare) * patch.normal,
            .radius_world = patch.radius_world,
            .is_capped = true};
}

/// The pixels of the pictures of both its sphere and its drum, which is narrower where the piece is
/// seen from the side.
std::optional<PixelBox> cover_of(const SlimPatch& patch, const SplatView& view) {
    constexpr double few_pixels = 4; // below it discs take more than they save: docs/slim.md
    const ScreenBounds ball =
        screen_bounds(Sphere{patch.centre_world, patch.radius_world}, view.space);
    if (ball.extent == ScreenExtent::Nothing) return std::nullopt;
    if (ball.extent == ScreenExtent::Everything)
        return PixelBox{-1, float(view.width) + 1, -1, float(view.height) + 1};
    Eigen::AlignedBox2d box(ball.lo, ball.hi);
    if (view.pixels_per_unit * box.sizes().maxCoeff() > few_pixels) {
        const ScreenBounds drum = screen_bounds(drum_around(patch), view.space, true);
        if (drum.extent == ScreenExtent::Rectangle)
            box = box.intersection(Eigen::AlignedBox2d(drum.lo, drum.hi));
        if (box.isEmpty()) return std::nullopt;
    }
    return cover_of(Eigen::AlignedBox2d(view.middle_pixels + view.pixels_per_unit * box.min(),
                                        view.middle_pixels + view.pixels_per_unit * box.max()),
                    view);
}

double depth_of(const Vec3d& p_world, const PictureSpace& space) {
    return -space.view_from_world.row(2).dot(p_world - space.eye_world);
}

/// Behind its place: shaders/quadrics/slim.glsl.
void put_piece(const SlimPatch& patch, double max_error_world, const SlimFade& fade,
               bool faces_front, const PictureSpace& space, Record& record) {
    const Mat3d& turn = space.view_from_world;
    const SlimQuadric f = slim_quadric(patch);
    const Mat3d a = turn * f.a * turn.transpose();
    const Vec3d b = turn * f.b;
    record.put(turn * (patch.centre_world - space.eye_world), patch.radius_world);
    record.put({a(0, 0), a(0, 1), a(0, 2), b.x()});
    record.put({a(1, 1), a(1, 2), a(2, 2), 0});
    record.put({b.y(), b.z(), f.c, patch.errors * max_error_world});
    record.put({fade.rise, fade.fall, faces_front ? 1.0 : 0.0,
                patch.is_any ? 3.0 : double(patch.plane_count)});
    for (std::size_t k = 0; k < 2; ++k) {
        const bool is_there = k < static_cast<std::size_t>(patch.plane_count);
        record.put(is_there ? Vec3d(turn * patch.planes[k].normal) : Vec3d(Vec3d::Zero()),
                   is_there ? patch.planes[k].offset_world : 1); // which keeps all
    }
}

} // namespace

bool shows_outside_only(const SlimSurface& surface, const SplatView& view) {
    return surface.is_closed && view.planes.empty() &&
           std::ranges::all_of(surface.levels, [&](const SlimLevel& level) {
               return std::ranges::all_of(level.patches, [&](const SlimPatch& patch) {
                   return depth_of(patch.centre_world, view.space) > patch.radius_world;
               });
           });
}

void append_splats(const SlimSurface& surface, std::size_t number, const SplatView& view,
                   Splats& splats) {
    const bool faces_front = shows_outside_only(surface, view);
    splats.shows_slims_inside |= !faces_front;
    const PictureSpace& space = view.space;
    const Vec3d forward = -space.view_from_world.row(2).transpose();
    for (std::size_t l = 0; l < surface.levels.size(); ++l) {
        const SlimLevel& level = surface.levels[l];
        const SlimFade fade = slim_fade(surface, l, view.pixels_per_unit);
        if (!space.is_perspective && !fade.is_seen(1, 1)) continue;
        append_in_order(
            SplatKind::Slim, level.patches.size(), splats,
            [&](std::size_t i, float* to) -> std::optional<PixelBox> {
                const SlimPatch& patch = level.patches[i];
                const double depth = depth_of(patch.centre_world, space);
                const double r = patch.radius_world;
                if (!(depth + r > 0)) return std::nullopt;
                if (space.is_perspective && !fade.is_seen(std::max(0.0, depth - r), depth + r))
                    return std::nullopt;
                if (faces_front &&
                    is_turned_away(patch, space.eye_world, space.is_perspective, forward))
                    return std::nullopt;
                if (is_cut_away(patch, view.planes)) return std::nullopt;
                const auto box = cover_of(patch, view);
                if (!box) return std::nullopt;
                Record record(to);
                record.put(*box, static_cast<double>(number));
                put_piece(patch, level.max_error_world, fade, faces_front, space, record);
                return box;
            });
    }
}

void put_body(const SlimPiece& piece, const PictureSpace& space, float* to) {
    Record record(to);
    put_piece(piece.patch, piece.max_error_world, {}, false, space, record);
}

} // namespace isocast
