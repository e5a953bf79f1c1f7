// SPDX-License-Identifier: MPL-2.0
#include "raycaster/primitives_reference.h"

#include "quadrics/quadric.h"
#include "quadrics/superquadric.h"
#include "raycaster/splats_on_gpu.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

double first_t(const Sphere& sphere, const Ray& ray) {
    const Vec3d o = sphere.centre_world - ray.origin_world;
    const Vec3d& v = ray.direction_world;
    const double a = v.squaredNorm();
    const double t0 = v.dot(o) / a;
    const double h = sphere.radius_world * sphere.radius_world - (v * t0 - o).squaredNorm();
    if (h < 0) return nowhere;
    const double half = std::sqrt(h / a);
    if (t0 - half >= 0) return t0 - half;
    return t0 + half >= 0 ? t0 + half : nowhere;
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

template<class Primitive>
Window window_of(const Primitive& primitive, const Picture& picture) {
    const ScreenBounds bounds = screen_bounds(primitive, picture.space);
    if (bounds.extent == ScreenExtent::Nothing) return {0, 0, 0, 0};
    if (bounds.extent == ScreenExtent::Everything) return picture.all();
    Eigen::AlignedBox2d box;
    for (int i = 0; i < 4; ++i) box.extend(bounds.corner(i));
    return picture.window(box.min().x(), box.max().x(), box.min().y(), box.max().y());
}

} // namespace

std::vector<SeenPrimitive> cast_primitives(const Primitives& with_dots, const Camera& camera,
                                           int width, int height) {
    const Picture picture{camera, width, height, pixels_per_unit(camera, height),
                          picture_space(camera)};
    const Primitives primitives =
        with_dots_as_spheres(with_dots, picture.space, picture.pixels_per_unit);
    std::vector<SeenPrimitive> seen(static_cast<std::size_t>(width) *
                                    static_cast<std::size_t>(height));
    constexpr int rows = 16; // of a strip, that one thread fills
    tbb::parallel_for(0, (height + rows - 1) / rows, [&](int strip) {
        const int first_row = strip * rows;
        const int last_row = std::min(first_row + rows, height);
        int number = 0;
        for_each_kind(primitives, [&](const auto& some) {
            for (const auto& one : some) {
                const Window window = window_of(one, picture);
                for (int y = std::max(window.y_lo, first_row); y < std::min(window.y_hi, last_row);
                     ++y)
                    for (int x = window.x_lo; x < window.x_hi; ++x) {
                        const Ray ray = camera_ray(camera, width, height, x + 0.5, y + 0.5);
                        double t = nowhere;
                        Vec3d normal = Vec3d::Zero();
                        if constexpr (std::is_same_v<std::decay_t<decltype(one)>, Sphere>) {
                            t = first_t(one, ray);
                            normal =
                                (ray.origin_world - one.centre_world + t * ray.direction_world) /
                                one.radius_world;
                        } else if (const auto hit =
                                       intersect(one, ray.origin_world, ray.direction_world)) {
                            t = hit->t;
                            normal = hit->normal;
                        }
                        SeenPrimitive& pixel =
                            seen[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                 static_cast<std::size_t>(x)];
                        if (t < pixel.t) pixel = {number, t, normal};
                    }
                ++number;
            }
        });
    });
    return seen;
}

} // namespace isocast
