// Pixels of bench_quadrics that are wrong.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/numbered_primitives.h"
#include "quadrics/quadrics_bench.h"

#include "raycaster/primitives_reference.h"

#include <fmt/format.h>

#include <numbers>
#include <random>

namespace isocast {

int wrong_pixels(Renderer& renderer, Primitives primitives, const Camera& camera) {
    number_by_colour(primitives);
    renderer.load({.primitives = std::make_shared<Primitives>(primitives)});
    renderer.draw(camera, width, height, {FrameImage::SplatColour});
    const Image drawn = renderer.read(FrameImage::SplatColour);
    const std::vector<SeenPrimitive> seen = cast_primitives(primitives, camera, width, height);
    int wrong = 0;
    for (std::size_t i = 0; i < seen.size(); ++i)
        wrong += number_of_colour(&drawn.rgba[4 * i]) != seen[i].number;
    return wrong;
}

void count_hard_errors(Renderer& renderer) {
    for (const double fov : {60.0, 90.0}) {
        const Camera camera{.eye_world = {0, 0, 5}, .fov_y_degrees = fov};
        fmt::print("spheres at the borders and corners, fov {}: {} wrong pixels\n", fov,
                   wrong_pixels(renderer, spheres_at_borders_and_corners(camera), camera));
    }
    const Primitives cut{.spheres = {{.centre_world = {0.9, 0, 5.1}, .radius_world = 0.5},
                                     {.centre_world = {-0.8, 0.2, 4.9}, .radius_world = 0.6},
                                     {.centre_world = {0, 0.1, 5.3}, .radius_world = 4}}};
    fmt::print("spheres across the eye's plane and around the eye: {} wrong pixels\n",
               wrong_pixels(renderer, cut, {.eye_world = {0, 0, 5}}));
}

void run_equation_7(Renderer& renderer) {
    constexpr int views = 8;
    constexpr double radius_pixels = 100;
    struct Method {
        bool is_equation_7;
        double nearest; // sphere of its scene, by the distance; the farthest one is at twice that
    };
    constexpr std::array methods{Method{true, 1}, Method{true, 0.5}, Method{true, 0.01},
                                 Method{false, 1}};
    fmt::print(
        "\nSigg et al. 2006, eq. 7 in float32: wrong pixels of a sphere {} pixels in radius, "
        "{} x {}, mean and most of {} views; planes: the near and the far one\n"
        "{:>16} {:>20} {:>20} {:>20} {:>16}\n",
        radius_pixels, width, height, views, "radius/distance", "planes around it", "d/2 to 2 d",
        "d/100 to 2 d", "ours");
    for (int digits = 1; digits <= 6; ++digits) {
        std::mt19937 random(4);
        std::normal_distribution<double> normal;
        std::array<int, methods.size()> sum{};
        std::array<int, methods.size()> most{};
        for (int view = 0; view < views; ++view) {
            const double x = normal(random);
            const double y = normal(random);
            const Vec3d direction = Vec3d(x, y, normal(random)).normalized();
            const double distance = std::pow(10, digits);
            // Some radii beside the middle, so that the sphere is anywhere in the picture.
            Camera camera{.eye_world = direction * distance,
                          .target_world = direction.unitOrthogonal() * (0.3 * view)};
            camera.fov_y_degrees =
                2 * std::atan(height / 2.0 / radius_pixels / distance) * 180 / std::numbers::pi;
            const Sphere sphere{.centre_world = Vec3d::Zero(), .radius_world = 1};
            const std::vector<SeenPrimitive> seen =
                cast_primitives({.spheres = {sphere}}, camera, width, height);
            for (std::size_t k = 0; k < methods.size(); ++k) {
                Primitives scene{.spheres = {sphere}};
                const Vec3d beside = (40 + 0.01 * distance) * direction.unitOrthogonal();
                if (methods[k].nearest < 1)
                    for (const double depth : {methods[k].nearest, 2.0})
                        scene.spheres.push_back(
                            {.centre_world = (1 - depth) * camera.eye_world + beside,
                             .radius_world = 1e-3 * distance});
                renderer.load({.primitives = std::make_shared<Primitives>(scene)});
                renderer.set_study({.meets_spheres_by_equation_7 = methods[k].is_equation_7});
                renderer.draw(camera, width, height, {FrameImage::Splat});
                const Image splats = renderer.read(FrameImage::Splat);
                int wrong = 0;
                for (std::size_t i = 0; i < seen.size(); ++i)
                    wrong += (splats.rgba[4 * i] > 0) != (seen[i].number >= 0);
                sum[k] += wrong;
                most[k] = std::max(most[k], wrong);
            }
        }
        const auto cell = [&](std::size_t k) {
            return fmt::format("{:.1f}, {}", double(sum[k]) / views, most[k]);
        };
        fmt::print("{:>16.0e} {:>20} {:>20} {:>20} {:>16}\n", std::pow(10, -digits), cell(0),
                   cell(1), cell(2), cell(3));
        std::fflush(stdout);
    }
    renderer.set_study({});
}

} // namespace isocast
