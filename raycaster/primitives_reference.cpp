// SPDX-License-Identifier: MPL-2.0
#include "raycaster/primitives_reference.h"

#include "quadrics/quadric.h"
#include "quadrics/slim_splats.h"
#include "quadrics/superquadric.h"
#include "raycaster/splats_on_gpu.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

namespace isocast {

namespace {

constexpr double nowhere = std::numeric_limits<double>::infinity();

/// Pixels from the top left, lo <= x < hi.
struct Window {
    int x_lo, x_hi;
    int y_lo, y_hi;
};

struct Picture {
    const Camera& camera;
    int width;
    int height;
    double pixels_per_unit;
    PictureSpace space;

    Window all() const { return {0, width, 0, height}; }
    /// Of x to the right and y upwards from the middle, in the plane of the picture.
    Window window(double x_lo, double x_hi, double y_lo, double y_hi) const {
        const auto pixel = [&](double at, int size, int spare) {
            return static_cast<int>(
                std::clamp(size / 2.0 + pixels_per_unit * at + spare, 0.0, double(size)));
        };
        return {pixel(x_lo, width, -3), pixel(x_hi, width, 4), pixel(-y_hi, height, -3),
                pixel(-y_lo, height, 4)};
    }
};

struct RayHit {
    double t = nowhere;
    Vec3d normal = Vec3d::Zero();
    Vec3d volumes = Vec3d::Zero(); // of triangles: shares of the corners
};

RayHit hit_of(const Sphere& sphere, const Ray& ray, double t_near) {
    const Vec3d o = sphere.centre_world - ray.origin_world;
    const Vec3d& v = ray.direction_world;
    const double a = v.squaredNorm();
    const double t0 = v.dot(o) / a;
    const double h = sphere.radius_world * sphere.radius_world - (v * t0 - o).squaredNorm();
    if (h < 0) return {};
    const double half = std::sqrt(h / a);
    const double t = t0 - half >= t_near ? t0 - half : t0 + half;
    if (t < t_near) return {};
    return {t, (t * v - o) / sphere.radius_world, Vec3d::Zero()};
}

/// The cone that holds the sphere, half as wide again, by its slopes along x and y.
Window window_of(const Sphere& sphere, const Picture& picture) {
    const Vec3d at =
        picture.space.view_from_world * (sphere.centre_world - picture.camera.eye_world);
    const double distance = at.norm();
    const double r = 1.5 * sphere.radius_world;
    if (!picture.space.is_perspective)
        return picture.window(at.x() - r, at.x() + r, at.y() - r, at.y() + r);
    if (r >= distance || at.z() > -r) return picture.all();
    // Seen along y, the sphere is a circle about (x, -z).
    const auto slopes = [&](double sideways) -> std::array<double, 2> {
        const double half_angle = std::asin(std::min(1.0, r / std::hypot(sideways, at.z())));
        const double angle = std::atan2(sideways, -at.z());
        constexpr double most = 0.4999 * std::numbers::pi;
        return {std::tan(std::clamp(angle - half_angle, -most, most)),
                std::tan(std::clamp(angle + half_angle, -most, most))};
    };
    const auto x = slopes(at.x());
    const auto y = slopes(at.y());
    return picture.window(x[0], x[1], y[0], y[1]);
}

/// By the signs of the volumes that the ray spans with the edges: one through an edge meets both
/// triangles there.
RayHit hit_of(const Triangle& triangle, const Ray& ray, double t_near) {
    std::array<Vec3d, 3> from_start;
    for (std::size_t k = 0; k < 3; ++k)
        from_start[k] = triangle.corners_world[k] - ray.origin_world;
    const Vec3d& v = ray.direction_world;
    Vec3d volumes;
    for (std::size_t k = 0; k < 3; ++k) { // far away corners alone are nearly parallel
        const Vec3d& a = from_start[(k + 1) % 3];
        volumes[static_cast<Eigen::Index>(k)] = v.dot(a.cross(from_start[(k + 2) % 3] - a));
    }
    const bool is_inside = (volumes.array() >= 0).all() || (volumes.array() <= 0).all();
    const Vec3d normal = area_normal(triangle);
    const double slant = normal.dot(v);
    if (!is_inside || slant == 0) return {};
    const double t = normal.dot(from_start[0]) / slant;
    if (!(t > 0 && t >= t_near)) return {};
    return {t, normal.stableNormalized(), volumes};
}

Window window_around(std::span<const Vec3d> corners_world, const Picture& picture) {
    Eigen::AlignedBox2d box;
    for (const Vec3d& corner : corners_world) {
        const Vec3d at = picture.space.view_from_world * (corner - picture.camera.eye_world);
        if (picture.space.is_perspective && !(at.z() < 0)) return picture.all();
        box.extend(Eigen::Vector2d(at.head<2>() / (picture.space.is_perspective ? -at.z() : 1)));
    }
    return picture.window(box.min().x(), box.max().x(), box.min().y(), box.max().y());
}

/// Of meshes, and without an inside.
template<class Primitive>
concept Element = requires(const Primitive& one) {
    one.corners_world;
};

bool is_flat(const Patch& patch) {
    return is_without_area(patch);
}
bool is_flat(const Tetrahedron& tetrahedron) {
    return is_without_volume(tetrahedron);
}

template<Element One>
RayHit hit_of(const One& one, const Ray& ray, double t_near) {
    if (is_flat(one)) return {};
    const auto hit = intersect(one, ray.origin_world, ray.direction_world, t_near);
    return hit ? RayHit{hit->t, hit->normal, Vec3d::Zero()} : RayHit{};
}

template<Element One>
Window window_of(const One& one, const Picture& picture) {
    return window_around(one.corners_world, picture);
}

template<class Primitive>
Window window_of(const Primitive& primitive, const Picture& picture) {
    const ScreenBounds bounds = screen_bounds(primitive, picture.space);
    if (bounds.extent == ScreenExtent::Nothing) return {0, 0, 0, 0};
    if (bounds.extent == ScreenExtent::Everything) return picture.all();
    Eigen::AlignedBox2d box;
    for (int i = 0; i < 4; ++i) box.extend(bounds.corner(i));
    return picture.window(box.min().x(), box.max().x(), box.min().y(), box.max().y());
}

template<class Primitive>
RayHit hit_of(const Primitive& primitive, const Ray& ray, double t_near) {
    const auto hit = intersect(primitive, ray.origin_world, ray.direction_world, t_near);
    return hit ? RayHit{hit->t, hit->normal, Vec3d::Zero()} : RayHit{};
}

/// What planes leave of a ray.
struct Kept {
    double t_near = 0;
    double t_far = nowhere;
    const CutPlane* plane = nullptr; // at t_near
};
Kept kept_by(const std::vector<CutPlane>& planes, const Ray& ray) {
    Kept kept;
    for (const CutPlane& plane : planes) {
        const double towards = plane.normal.dot(ray.direction_world);
        const double room = plane.offset_world - plane.normal.dot(ray.origin_world);
        const double t = towards == 0 ? (room < 0 ? -1 : nowhere) : room / towards;
        if (towards >= 0)
            kept.t_far = std::min(kept.t_far, t);
        else if (t > kept.t_near)
            kept = {t, kept.t_far, &plane};
    }
    return kept;
}

/// With the distance by which hits are ordered, less where caps of one plane lie deep inside.
struct OrderedHit : RayHit {
    double order = nowhere;
};
template<class Primitive>
OrderedHit cut_hit_of(const Primitive& primitive, const Ray& ray, const Kept& kept, CutLook look) {
    OrderedHit hit{hit_of(primitive, ray, kept.t_near)};
    if (kept.plane && look == CutLook::Flat && hit.normal.dot(ray.direction_world) > 0)
        hit.normal = kept.plane->normal;
    hit.order = hit.t;
    if constexpr (!Element<Primitive>) {
        const Vec3d at = ray.origin_world + kept.t_near * ray.direction_world;
        const double depth =
            kept.plane && look == CutLook::Capped ? depth_inside(primitive, at) : 0;
        if (depth < 0) {
            hit.t = kept.t_near;
            hit.normal = kept.plane->normal;
            hit.order = hit.t * (1 + 0.5 * depth / (1 - depth));
        }
    }
    return hit.t <= kept.t_far ? hit : OrderedHit{};
}

template<class Primitive>
Vec3d colour_of(const Primitive& primitive, const Vec3d&) {
    return primitive.colour;
}
Vec3d colour_of(const Cylinder& stick, const Vec3d& p_world) {
    const Vec3d axis = stick.b_world - stick.a_world;
    const bool is_at_b = (p_world - 0.5 * (stick.a_world + stick.b_world)).dot(axis) > 0;
    return is_at_b ? stick.colour_b.value_or(stick.colour) : stick.colour;
}

/// Of SLIM surfaces, pixel by pixel: the pieces that their rays meet. The one whose sheet ends
/// first shows.
class SlimPixels {
public:
    /// surfaces     must outlive it
    /// first, count of the pixels that it looks at
    SlimPixels(const std::vector<SlimSurface>& surfaces, const SplatView& view, std::size_t first,
               std::size_t count)
        : surfaces_(surfaces), view_(view), first_(first), fragments_(count) {}

    /// look_at  (window, f): calls f(ray, kept, pixel) for the pixels of the window
    template<class LookAt>
    void cast(const Picture& picture, LookAt look_at) {
        for (std::size_t s = 0; s < surfaces_.size(); ++s) {
            const bool faces_front = shows_outside_only(surfaces_[s], view_);
            for (std::size_t l = 0; l < surfaces_[s].levels.size(); ++l) {
                const SlimLevel& level = surfaces_[s].levels[l];
                const SlimFade fade = slim_fade(surfaces_[s], l, view_.pixels_per_unit);
                for (const SlimPatch& patch : level.patches)
                    look_at(window_of(Sphere{patch.centre_world, patch.radius_world}, picture),
                            [&](const Ray& ray, const Kept& kept, std::size_t pixel) {
                                auto fragment =
                                    slim_fragment(patch, level.max_error_world, ray.origin_world,
                                                  ray.direction_world, faces_front, kept.t_near);
                                if (!fragment || fragment->hit.t > kept.t_far) return;
                                fragment->hit.weight *=
                                    fade.at(view_.space.is_perspective ? fragment->hit.t : 1);
                                if (fragment->hit.weight > 0)
                                    fragments_[pixel - first_].push_back({s, *fragment});
                            });
            }
        }
    }

    struct Shown {
        std::size_t surface = 0;
        SlimHit hit;
    };
    std::optional<Shown> shown(std::size_t pixel) const {
        const auto& met = fragments_[pixel - first_];
        if (met.empty()) return std::nullopt;
        const std::size_t surface = std::ranges::min_element(met, {}, [](const Fragment& f) {
                                        return f.of_surface.hit.t + f.of_surface.reach;
                                    })->surface;
        std::vector<SlimFragment> own;
        for (const Fragment& f : met)
            if (f.surface == surface) own.push_back(f.of_surface);
        return Shown{surface, *blended(own, view_.space.view_from_world.row(2))};
    }

private:
    struct Fragment {
        std::size_t surface;
        SlimFragment of_surface;
    };
    const std::vector<SlimSurface>& surfaces_;
    const SplatView& view_;
    std::size_t first_;
    std::vector<std::vector<Fragment>> fragments_;
};

/// Of a mesh with normals at corners.
/// twin  shaders/quadrics/triangle.glsl: smooth_normal()
Vec3d smooth_normal(const TriangleMesh& mesh, std::size_t triangle, const RayHit& hit,
                    const Vec3d& direction) {
    const auto corners = corner_normals_of(mesh, triangle);
    Vec3d normal = Vec3d::Zero();
    for (std::size_t k = 0; k < 3; ++k)
        normal += std::abs(hit.volumes[static_cast<Eigen::Index>(k)]) * corners[k].cast<double>();
    normal.normalize();
    const double away = normal.dot(direction);
    const bool is_seen_from_outside = hit.normal.dot(direction) <= 0;
    if (is_seen_from_outside == (away > 0))
        normal -= 2 * away / direction.squaredNorm() * direction;
    return normal;
}

} // namespace

std::vector<SeenPrimitive> cast_primitives(const Primitives& with_dots, const Camera& camera,
                                           int width, int height, const Cut& cut,
                                           const std::optional<PicturePart>& asked_part) {
    const PicturePart part = asked_part.value_or(PicturePart{.width = width, .height = height});
    const std::vector<CutPlane> planes = planes_of(cut, camera);
    const Picture picture{camera, width, height, pixels_per_unit(camera, height),
                          picture_space(camera)};
    const Primitives primitives =
        with_dots_as_spheres(with_dots, picture.space, picture.pixels_per_unit);
    const SplatView view{
        .space = picture.space, .pixels_per_unit = picture.pixels_per_unit, .planes = planes};
    std::vector<SeenPrimitive> seen(static_cast<std::size_t>(part.width) *
                                    static_cast<std::size_t>(part.height));
    std::vector<double> orders(seen.size(), nowhere);
    constexpr int rows = 16; // of a strip, that one thread fills
    tbb::parallel_for(0, (part.height + rows - 1) / rows, [&](int strip) {
        const int first_row = part.y + strip * rows;
        const int last_row = std::min(first_row + rows, part.y + part.height);
        int number = 0;
        /// visit  (ray, kept, pixel of the part)
        const auto look_at = [&](const Window& window, auto visit) {
            for (int y = std::max(window.y_lo, first_row); y < std::min(window.y_hi, last_row); ++y)
                for (int x = std::max(window.x_lo, part.x);
                     x < std::min(window.x_hi, part.x + part.width); ++x) {
                    const Ray ray = camera_ray(camera, width, height, x + 0.5 + part.shift.x(),
                                               y + 0.5 + part.shift.y());
                    visit(ray, kept_by(planes, ray),
                          static_cast<std::size_t>(y - part.y) *
                                  static_cast<std::size_t>(part.width) +
                              static_cast<std::size_t>(x - part.x));
                }
        };
        const auto offer = [&](const OrderedHit& hit, const Ray& ray, std::size_t pixel,
                               auto shade) {
            if (!(hit.order < orders[pixel])) return;
            orders[pixel] = hit.order;
            seen[pixel] = {number, hit.t, hit.normal, hit.normal, Vec3d::Zero()};
            shade(hit, ray, seen[pixel]);
        };
        const auto cast_one = [&](const auto& one, auto shade) {
            look_at(window_of(one, picture),
                    [&](const Ray& ray, const Kept& kept, std::size_t pixel) {
                        offer(cut_hit_of(one, ray, kept, cut.look), ray, pixel, shade);
                    });
        };
        for_each_kind(primitives, [&](const auto& some) {
            for (const auto& one : some) {
                cast_one(one, [&](const RayHit& hit, const Ray& ray, SeenPrimitive& pixel) {
                    pixel.colour = colour_of(one, ray.origin_world + hit.t * ray.direction_world);
                });
                ++number;
            }
        });
        for (const TriangleMesh& mesh : primitives.meshes) {
            for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
                cast_one(triangle_of(mesh, i), [&](const RayHit& hit, const Ray& ray,
                                                   SeenPrimitive& pixel) {
                    pixel.colour = mesh.colour;
                    if (!mesh.normals_world.empty())
                        pixel.shaded_normal = smooth_normal(mesh, i, hit, ray.direction_world);
                });
            ++number;
        }
        const auto cast_mesh = [&](const auto& mesh, std::size_t count, auto element_of) {
            for (std::size_t i = 0; i < count; ++i)
                cast_one(element_of(mesh, i), [&](const RayHit&, const Ray&, SeenPrimitive& pixel) {
                    pixel.colour = mesh.colour;
                });
            ++number;
        };
        for (const PatchMesh& mesh : primitives.patches)
            cast_mesh(mesh, mesh.quads.size(), patch_of);
        for (const TetrahedralMesh& mesh : primitives.tetrahedra)
            cast_mesh(mesh, mesh.tetrahedra.size(), tetrahedron_of);
        if (primitives.slims.empty()) return;
        const auto width_of_part = static_cast<std::size_t>(part.width);
        SlimPixels slims(primitives.slims, view,
                         static_cast<std::size_t>(first_row - part.y) * width_of_part,
                         static_cast<std::size_t>(last_row - first_row) * width_of_part);
        slims.cast(picture, look_at);
        const int first_slim = number;
        look_at(picture.all(), [&](const Ray& ray, const Kept& kept, std::size_t pixel) {
            const auto shown = slims.shown(pixel);
            if (!shown) return;
            const SlimHit& met = shown->hit;
            OrderedHit hit{{met.t, met.normal, Vec3d::Zero()}, met.t};
            if (kept.plane && cut.look == CutLook::Flat && met.normal.dot(ray.direction_world) > 0)
                hit.normal = kept.plane->normal;
            number = first_slim + static_cast<int>(shown->surface);
            offer(hit, ray, pixel, [&](const RayHit&, const Ray&, SeenPrimitive& one) {
                one.colour = primitives.slims[shown->surface].colour;
            });
        });
    });
    return seen;
}

} // namespace isocast
