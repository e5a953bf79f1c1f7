// SPDX-License-Identifier: MPL-2.0
#include "quadrics/splats.h"

#include "quadrics/hull_cover.h"
#include "quadrics/in_parallel.h"
#include "quadrics/patch_splats.h"
#include "quadrics/quadric.h"
#include "quadrics/scrambled.h"
#include "quadrics/slim_splats.h"
#include "quadrics/superquadric.h"
#include "quadrics/triangle_splats.h"
#include "quadrics/visibility.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace isocast {

namespace {

/// Rectangles that reach farther are cut to the picture: floats know them to a 64th of a pixel.
constexpr double greatest_pixels = 1 << 17;

/// In [0, 1), as if at random.
double share_of(std::uint64_t number) {
    return static_cast<double>(scrambled(number) >> 11) * 0x1p-53;
}

/// How large one of many is drawn, of the full size of those that are kept: on average over all
/// numbers it is `kept`, which is less than 1. Each goes from 0 to 1 while `kept` grows by two
/// thirds, or to 1.
double thinned(double kept, std::uint64_t number) {
    const double growing = std::min(kept / 4, 1 - kept); // half the share of those
    return std::clamp((kept + growing - share_of(number)) / (2 * growing), 0.0, 1.0);
}

/// The radius [pixels] with which something as far away as p is seen.
double radius_in_pixels(const Vec3d& p_world, double radius_world, const SplatView& view) {
    const double depth = -view.space.view_from_world.row(2).dot(p_world - view.space.eye_world);
    const double scale = view.space.is_perspective ? 1 / std::max(depth, radius_world) : 1;
    return radius_world * scale * view.pixels_per_unit;
}

/// As it is drawn where detail ends; nothing if others stand for it.
template<class Primitive>
std::optional<Primitive> thinned_out(const Primitive& primitive, std::uint64_t, const SplatView&) {
    return primitive;
}
template<>
std::optional<Sphere> thinned_out(const Sphere& sphere, std::uint64_t number,
                                  const SplatView& view) {
    if (view.detail_pixels == 0) return sphere;
    const double size =
        radius_in_pixels(sphere.centre_world, sphere.radius_world, view) / view.detail_pixels;
    if (!(size < 1)) return sphere;
    const double area = thinned(size * size, number);
    Sphere drawn = sphere;
    drawn.radius_world *= std::sqrt(area) / size;
    return area > 0 ? std::optional(drawn) : std::nullopt;
}
template<>
std::optional<Cylinder> thinned_out(const Cylinder& stick, std::uint64_t number,
                                    const SplatView& view) {
    if (view.detail_pixels == 0) return stick;
    const Vec3d middle = (stick.a_world + stick.b_world) / 2;
    const double size = radius_in_pixels(middle, stick.radius_world, view) / view.detail_pixels;
    if (!(size < 1)) return stick;
    const double width = thinned(size, number);
    Cylinder drawn = stick;
    drawn.radius_world *= width / size;
    return width > 0 ? std::optional(drawn) : std::nullopt;
}

/// Where a primitive is drawn: a corner and two sides [pixels].
struct Rectangle {
    Eigen::Vector2f corner = Eigen::Vector2f::Zero();
    Eigen::Vector2f side_a = Eigen::Vector2f::Zero();
    Eigen::Vector2f side_b = Eigen::Vector2f::Zero();
};

/// The whole part.
Rectangle everywhere(const SplatView& view) {
    return {{-1, -1}, {float(view.width) + 2, 0}, {0, float(view.height) + 2}};
}

/// throws nothing; `bounds` is not Nothing
Rectangle rectangle_of(const ScreenBounds& bounds, const SplatView& view) {
    if (bounds.extent == ScreenExtent::Everything) return everywhere(view);
    const Eigen::Vector2d lo =
        bounds.lo * view.pixels_per_unit - Eigen::Vector2d::Constant(margin_pixels);
    const Eigen::Vector2d hi =
        bounds.hi * view.pixels_per_unit + Eigen::Vector2d::Constant(margin_pixels);
    const Eigen::Vector2d across = bounds.other_axis();
    const Eigen::Vector2d corner = view.middle_pixels + bounds.axis * lo.x() + across * lo.y();
    const double reach = std::max(
        {lo.cwiseAbs().maxCoeff(), hi.cwiseAbs().maxCoeff(), corner.cwiseAbs().maxCoeff()});
    if (!(reach < greatest_pixels)) return everywhere(view);
    return {corner.cast<float>(), (bounds.axis * (hi.x() - lo.x())).cast<float>(),
            (across * (hi.y() - lo.y())).cast<float>()};
}

PixelBox box_of(const Rectangle& r) {
    const Eigen::Vector2f lo = r.corner + r.side_a.cwiseMin(0) + r.side_b.cwiseMin(0);
    const Eigen::Vector2f hi = r.corner + r.side_a.cwiseMax(0) + r.side_b.cwiseMax(0);
    return {lo.x(), hi.x(), lo.y(), hi.y()};
}

Rectangle square_around(const Rectangle& r) {
    const float side = (r.side_a.cwiseAbs() + r.side_b.cwiseAbs()).maxCoeff();
    const Eigen::Vector2f middle = r.corner + (r.side_a + r.side_b) / 2;
    return {middle - Eigen::Vector2f::Constant(side / 2), {side, 0}, {0, side}};
}

FootprintView footprint_view(const SplatView& view) {
    return {.is_perspective = view.space.is_perspective,
            .width = view.width,
            .height = view.height,
            .middle_pixels = view.middle_pixels,
            .pixels_per_unit = view.pixels_per_unit};
}

/// How a primitive is found in the picture. A sphere's rectangle is the box of its footprint.
struct Outline {
    Footprint footprint{1, -1, 1, -1, 0, 0, 0, 0, 0}; // nowhere
    Rectangle rectangle;
};

/// Without a disc: it hides nothing.
Outline outline_of(const ScreenBounds& bounds, double nearest_depth, const SplatView& view) {
    Outline outline;
    if (bounds.extent == ScreenExtent::Nothing) return outline;
    outline.rectangle = rectangle_of(bounds, view);
    const PixelBox box = box_of(outline.rectangle);
    const double nearest = view.space.is_perspective ? std::max(nearest_depth, 0.0) : nearest_depth;
    outline.footprint = {box.x_lo, box.x_hi, box.y_lo, box.y_hi, static_cast<float>(nearest),
                         0,        0,        0,        0};
    return outline;
}

Vec3d in_view(const PictureSpace& space, const Vec3d& p_world) {
    return space.view_from_world * (p_world - space.eye_world);
}

Outline outline_of(const Sphere& sphere, const SplatView& view) {
    Outline outline;
    const Vec3d centre_view = in_view(view.space, sphere.centre_world);
    if (centre_view.z() - sphere.radius_world >= 0) return outline;
    Footprint& footprint = outline.footprint;
    footprint = sphere_footprint(footprint_view(view), centre_view, sphere.radius_world);
    // One that the plane of parallel rays' starts cuts open shows its far side.
    if (!view.space.is_perspective && footprint.nearest_depth < 0) footprint.disc_radius = 0;
    return outline;
}

/// Of one that holds the ellipsoid of the same axes.
///
/// half_depth  half its extent along the view
template<class Primitive>
Outline outline_with_disc(const Primitive& primitive, double half_depth, const SplatView& view) {
    const Vec3d centre_view = in_view(view.space, primitive.centre_world);
    Outline outline =
        outline_of(screen_bounds(primitive, view.space), -centre_view.z() - half_depth, view);
    Footprint& footprint = outline.footprint;
    // A ray that meets a ball within meets the primitive before it. The norm is not less than the
    // greatest singular value.
    const double radius = 1 / primitive.axes_world.inverse().norm();
    if (footprint.x_lo <= footprint.x_hi && centre_view.z() + half_depth < 0) {
        const Footprint ball = sphere_footprint(footprint_view(view), centre_view, radius);
        footprint.disc_x = ball.disc_x;
        footprint.disc_y = ball.disc_y;
        footprint.disc_radius = ball.disc_radius;
        footprint.disc_depth = ball.disc_depth;
    }
    return outline;
}

Outline outline_of(const Ellipsoid& ellipsoid, const SplatView& view) {
    const Vec3d depth = view.space.view_from_world.row(2).transpose();
    return outline_with_disc(ellipsoid, (ellipsoid.axes_world.transpose() * depth).norm(), view);
}

// With exponents of norms from 2 on, its norm is at most that of the ball.
Outline outline_of(const Superquadric& superquadric, const SplatView& view) {
    const Vec3d depth = view.space.view_from_world.row(2).transpose();
    return outline_with_disc(superquadric, support(superquadric, depth), view);
}

Outline outline_between(const Vec3d& a_world, const Vec3d& b_world, double radius_a,
                        double radius_b, const ScreenBounds& bounds, const SplatView& view) {
    const double axis_z =
        view.space.view_from_world.row(2).dot((b_world - a_world).stableNormalized());
    const double tilt = std::sqrt(std::max(0.0, 1 - axis_z * axis_z)); // of the discs at the ends
    const double nearest = std::min(-in_view(view.space, a_world).z() - radius_a * tilt,
                                    -in_view(view.space, b_world).z() - radius_b * tilt);
    return outline_of(bounds, nearest, view);
}

Outline outline_of(const Cylinder& c, const SplatView& view) {
    const bool is_upright = view.shape != BoundingShape::Rectangle;
    return outline_between(c.a_world, c.b_world, c.radius_world, c.radius_world,
                           screen_bounds(c, view.space, is_upright), view);
}

Outline outline_of(const Cone& c, const SplatView& view) {
    const bool is_upright = view.shape != BoundingShape::Rectangle;
    return outline_between(c.a_world, c.b_world, c.radius_a_world, c.radius_b_world,
                           screen_bounds(c, view.space, is_upright), view);
}

Outline outline_of(const ClippedQuadric& quadric, const SplatView& view) {
    const double half_depth =
        (quadric.axes_world.transpose() * view.space.view_from_world.row(2).transpose())
            .cwiseAbs()
            .sum();
    return outline_of(screen_bounds(quadric, view.space),
                      -in_view(view.space, quadric.centre_world).z() - half_depth, view);
}

/// The same of what the planes leave. What is cut hides nothing.
template<class Primitive>
Outline outline_behind_planes(const Primitive& primitive, const SplatView& view) {
    if (is_cut_away(primitive, view.planes)) return {};
    Outline outline = outline_of(primitive, view);
    for (const CutPlane& plane : view.planes)
        if (reach_along(primitive, plane.normal).greatest > plane.offset_world)
            outline.footprint.disc_radius = 0;
    return outline;
}

/// Where a footprint is drawn: its box, of which what is hidden is left out unless shapes are
/// compared.
PixelBox drawn_box(const Footprint& f, const VisibleFootprint& seen, BoundingShape shape) {
    if (shape != BoundingShape::Rectangle) return {f.x_lo, f.x_hi, f.y_lo, f.y_hi};
    return {std::max(f.x_lo, float(seen.x_lo)), std::min(f.x_hi, float(seen.x_hi)),
            std::max(f.y_lo, float(seen.y_lo)), std::min(f.y_hi, float(seen.y_hi))};
}

Rectangle rectangle_of(const PixelBox& box) {
    constexpr auto margin = static_cast<float>(margin_pixels);
    return {{box.x_lo - margin, box.y_lo - margin},
            {box.x_hi - box.x_lo + 2 * margin, 0},
            {0, box.y_hi - box.y_lo + 2 * margin}};
}

/// r  of the whole primitive; none of a sphere
Rectangle drawn_rectangle(const PixelBox& box, const Rectangle* r, BoundingShape shape) {
    const Rectangle upright = rectangle_of(box);
    if (r == nullptr) return shape == BoundingShape::Square ? square_around(upright) : upright;
    if (shape == BoundingShape::Square) return square_around(*r);
    const bool is_smaller =
        upright.side_a.x() * upright.side_b.y() < r->side_a.norm() * r->side_b.norm();
    return shape == BoundingShape::Rectangle && is_smaller ? upright : *r;
}

} // namespace

void put_body(const Sphere& sphere, const PictureSpace& space, float* to) {
    const Vec3d o = in_view(space, sphere.centre_world);
    const double r = sphere.radius_world;
    const double distance = o.stableNorm();
    Record record(to);
    record.put({(distance - r) * (distance + r), 0, 0, 0});
    record.put({o.x(), o.y(), o.z(), r});
}

void put_body(const Superquadric& superquadric, const PictureSpace& space, float* to) {
    const auto seen = seen_from<double>(superquadric, space.eye_world);
    const Vec3d centre = space.view_from_world * seen.centre;
    const Mat3d m = seen.local_from_world * space.view_from_world.transpose();
    Record record(to);
    record.put({centre.x(), centre.y(), centre.z(), seen.exponents.p});
    record.put({m(0, 0), m(0, 1), m(0, 2), seen.exponents.r});
    record.put({m(1, 0), m(1, 1), m(1, 2), 0});
    record.put({m(2, 0), m(2, 1), m(2, 2), 0});
}

template<class Primitive>
void put_body(const Primitive& primitive, const PictureSpace& space, float* to) {
    const auto seen = seen_from<double>(quadric_of(primitive), space.eye_world);
    const Vec3d centre = space.view_from_world * seen.centre;
    Record record(to);
    record.put({centre.x(), centre.y(), centre.z(), seen.value_at_origin});
    const Mat3d m = seen.local_from_world * space.view_from_world.transpose();
    // Parallel rays start elsewhere.
    const bool is_near = seen.is_near && space.is_perspective;
    const int flags = int{is_near} + 2 * int{seen.has_cap[0]} + 4 * int{seen.has_cap[1]};
    if constexpr (std::is_same_v<Primitive, Cylinder> || std::is_same_v<Primitive, Cone>) {
        const Vec3d axis = m.row(2).normalized();
        record.put({axis.x(), axis.y(), axis.z(), m.row(2).norm()});
        record.put({m.row(0).norm(), seen.radius_slope, double(flags), 0});
        return;
    }
    record.put({m(0, 0), m(0, 1), m(0, 2), double(flags)});
    record.put({m(1, 0), m(1, 1), m(1, 2), 0});
    record.put({m(2, 0), m(2, 1), m(2, 2), seen.c});
    if constexpr (std::is_same_v<Primitive, ClippedQuadric>) {
        record.put({seen.a(0, 0), seen.a(0, 1), seen.a(0, 2), seen.b.x()});
        record.put({seen.a(1, 1), seen.a(1, 2), seen.a(2, 2), seen.b.y()});
        record.put({seen.b.z(), 0, 0, 0});
    }
}
template void put_body(const Ellipsoid&, const PictureSpace&, float*);
template void put_body(const Cylinder&, const PictureSpace&, float*);
template void put_body(const Cone&, const PictureSpace&, float*);
template void put_body(const ClippedQuadric&, const PictureSpace&, float*);

Primitives with_dots_as_spheres(Primitives primitives, const PictureSpace& space,
                                double pixels_per_unit) {
    for (const Dot& dot : primitives.dots) {
        const double radius = dot.radius_pixels / pixels_per_unit; // of slope, or in the world
        // Behind the eye as large as in front, for the shadow; at the eye as good as nothing.
        const double depth = std::abs(in_view(space, dot.centre_world).z());
        const double radius_world =
            space.is_perspective ? depth * (radius / std::hypot(1, radius)) : radius;
        primitives.spheres.push_back(
            {dot.centre_world, std::max(radius_world, least_glyph_size), dot.colour});
    }
    primitives.dots.clear();
    return primitives;
}

Splats splats_of(const Primitives& primitives, const SplatView& view) {
    const std::size_t count = primitives.solid_count();
    const auto footprints = std::make_unique_for_overwrite<Footprint[]>(count);
    const std::size_t sphere_count = primitives.spheres.size(); // which come first
    const auto rectangles = std::make_unique_for_overwrite<Rectangle[]>(count - sphere_count);
    in_parallel(count, [&](std::size_t i) {
        visit_solid(primitives, i, [&](const auto& primitive) {
            const auto drawn = thinned_out(primitive, i, view);
            const Outline outline = drawn ? outline_behind_planes(*drawn, view) : Outline{};
            footprints[i] = outline.footprint;
            if (i >= sphere_count) rectangles[i - sphere_count] = outline.rectangle;
        });
    });
    const std::vector<VisibleFootprint> visible =
        visible_footprints({footprints.get(), count}, view.width, view.height);

    Splats out;
    std::array<std::vector<VisibleFootprint>, splat_kind_count> of_kind;
    for (const VisibleFootprint& seen : visible)
        visit_solid(primitives, seen.number, [&](const auto& primitive) {
            of_kind[static_cast<std::size_t>(splat_kind_of(primitive))].push_back(seen);
        });
    out.boxes.resize(visible.size());
    PixelBox* box_of_slot = out.boxes.data();
    for (std::size_t k = 0; k < of_kind.size(); ++k) {
        const auto floats = static_cast<std::size_t>(splat_floats[k]);
        out.records[k].resize(floats * of_kind[k].size());
        in_parallel(of_kind[k].size(), [&](std::size_t slot) {
            const VisibleFootprint& seen = of_kind[k][slot];
            const std::uint32_t i = seen.number;
            const bool is_sphere = i < sphere_count;
            const PixelBox box = drawn_box(footprints[i], seen, view.shape);
            box_of_slot[slot] = box;
            const Rectangle r = drawn_rectangle(
                box, is_sphere ? nullptr : &rectangles[i - sphere_count], view.shape);
            float* to = out.records[k].data() + floats * slot;
            if (is_sphere)
                Record(to).put({r.corner.x(), r.corner.y(), r.side_a.x(), r.side_b.y()});
            else
                Record(to).put({r.corner.x(), r.corner.y(), r.side_a.x(), r.side_a.y(),
                                r.side_b.x(), r.side_b.y(), double(i), 0});
            visit_solid(primitives, i, [&](const auto& primitive) {
                const auto drawn = *thinned_out(primitive, i, view);
                to += place_floats(splat_kind_of(drawn));
                put_body(drawn, view.space, to);
                if constexpr (std::is_same_v<std::decay_t<decltype(primitive)>, Sphere>)
                    to[1] = static_cast<float>(i);
            });
        });
        box_of_slot += of_kind[k].size();
    }
    for (std::size_t m = 0, number = 0; m < primitives.meshes.size(); ++m) {
        append_splats(primitives.meshes[m], {primitives.solid_count() + m, number}, view, out);
        number += primitives.meshes[m].triangles.size();
    }
    std::size_t number = primitives.solid_count() + primitives.meshes.size();
    for (const PatchMesh& mesh : primitives.patches) append_splats(mesh, number++, view, out);
    for (const TetrahedralMesh& mesh : primitives.tetrahedra)
        append_splats(mesh, number++, view, out);
    for (const SlimSurface& surface : primitives.slims) append_splats(surface, number++, view, out);
    return out;
}

} // namespace isocast
