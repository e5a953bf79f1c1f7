// Pictures of primitives against a double ray caster, pixel by pixel.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../../bench/quadrics/numbered_primitives.h"
#include "raycaster/primitives_reference.h"
#include "raycaster/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace isocast::test {

struct Judgement {
    int wrong = 0;          // pixels that show another primitive, or one where there is none
    int seen = 0;           // pixels that show one
    double worst_error = 0; // how far hits are off the surface, by their distance from the eye
    std::vector<std::string> pixels; // the first wrong ones
};

/// What rays meet with all superquadrics larger by a share of their size.
inline std::vector<SeenPrimitive> cast_grown(Primitives primitives, double share,
                                             const Camera& camera, int width, int height,
                                             const Cut& cut) {
    for (Superquadric& s : primitives.superquadrics) s.axes_world *= 1 + share;
    return cast_primitives(primitives, camera, width, height, cut);
}

/// Draws the primitives, numbered by their colours, and compares.
///
/// silhouette  superquadrics may be larger or smaller by such a share of their size
inline Judgement judge(Renderer& renderer, Primitives primitives, const Camera& camera, int width,
                       int height, double silhouette = 0, const Cut& cut = {}) {
    number_by_colour(primitives);
    renderer.load({.primitives = std::make_shared<Primitives>(primitives), .cut = cut});
    renderer.draw(camera, width, height, {FrameImage::Hit, FrameImage::SplatColour});
    const Image hits = renderer.read(FrameImage::Hit);
    const Image colours = renderer.read(FrameImage::SplatColour);
    const std::vector<SeenPrimitive> shown =
        cast_primitives(primitives, camera, width, height, cut);
    std::vector<std::vector<SeenPrimitive>> beside;
    if (silhouette > 0)
        for (const double share : {silhouette, -silhouette})
            beside.push_back(cast_grown(primitives, share, camera, width, height, cut));
    Judgement judgement;
    for (std::size_t i = 0; i < shown.size(); ++i) {
        const int number = number_of_colour(&colours.rgba[4 * i]);
        judgement.seen += number >= 0;
        EXPECT_EQ(number >= 0, hits.rgba[4 * i + 3] != 0);
        if (number != shown[i].number) {
            if (std::ranges::any_of(beside, [&](auto& other) { return other[i].number == number; }))
                continue;
            if (++judgement.wrong <= 5)
                judgement.pixels.push_back(std::to_string(i) + ": " + std::to_string(number) +
                                           " for " + std::to_string(shown[i].number));
            continue;
        }
        if (number < 0) continue;
        const int x = static_cast<int>(i % static_cast<std::size_t>(width));
        const int y = static_cast<int>(i / static_cast<std::size_t>(width));
        const Ray ray = camera_ray(camera, width, height, x + 0.5, y + 0.5);
        const Vec3d p = ray.origin_world - camera.eye_world + ray.direction_world * shown[i].t;
        const Vec3d drawn = Eigen::Map<const Eigen::Vector3f>(&hits.rgba[4 * i]).cast<double>();
        judgement.worst_error =
            std::max(judgement.worst_error, std::abs(shown[i].normal.dot(drawn - p)) / p.norm());
    }
    return judgement;
}

/// Where the ray of a pixel hits [world].
///
/// i  the pixel's first number
inline Vec3d point_at(const Image& hits, std::size_t i, const Camera& camera) {
    return camera.eye_world + Eigen::Map<const Eigen::Vector3f>(&hits.rgba[i]).cast<double>();
}

/// FrameImage::Shadow, hard ones, Occlusion within 1, and Hit.
///
/// light  unit, towards it [world]
inline std::array<Image, 3> shadows_and_sky(Renderer& renderer, Primitives primitives,
                                            const Vec3d& light, const Camera& camera, int size) {
    Look look;
    look.lights = {{.direction = light, .is_in_view_space = false, .shadow = Shadow::Hard}};
    look.effects.occlusion.strength = 1;
    look.effects.occlusion.distance_world = 1;
    renderer.load(
        {.look = look, .primitives = std::make_shared<Primitives>(std::move(primitives))});
    renderer.draw(camera, size, size, {FrameImage::Shadow, FrameImage::Occlusion, FrameImage::Hit});
    return {renderer.read(FrameImage::Shadow), renderer.read(FrameImage::Occlusion),
            renderer.read(FrameImage::Hit)};
}

struct Holes {
    int met = 0;   // pixels whose rays meet what is expected
    int holes = 0; // those of them that show nothing
};

/// Draws one thing, and looks where rays meet another.
inline Holes holes_in(Renderer& renderer, const Primitives& drawn, const Primitives& expected,
                      const Camera& camera, int size) {
    renderer.load({.primitives = std::make_shared<Primitives>(drawn)});
    renderer.draw(camera, size, size, {FrameImage::Hit});
    const Image hits = renderer.read(FrameImage::Hit);
    const std::vector<SeenPrimitive> met = cast_primitives(expected, camera, size, size);
    Holes out;
    for (std::size_t i = 0; i < met.size(); ++i) {
        out.met += met[i].number >= 0;
        out.holes += met[i].number >= 0 && hits.rgba[4 * i + 3] == 0;
    }
    return out;
}

/// Of a closed mesh: pixels whose rays pass a ball in it and that show nothing.
inline int holes_before_ball(Renderer& renderer, const Primitives& drawn, double radius_world,
                             const Camera& camera, int size) {
    const Holes seen =
        holes_in(renderer, drawn, {.spheres = {{.radius_world = radius_world}}}, camera, size);
    EXPECT_GT(seen.met, 1000);
    return seen.holes;
}

struct ShadowCounts {
    int dark = 0;
    int lit = 0;
};

/// Draws hard shadows, and expects them where they belong on the upper side (y) of one primitive.
///
/// light     unit, towards it [world]
/// receiver  the primitive's number
/// is_lit    (p_world) -> std::optional<bool>: nothing too near to a shadow's border to tell
template<class IsLit>
ShadowCounts judge_hard_shadows(Renderer& renderer, const Primitives& primitives,
                                const Vec3d& light, const Camera& camera, int size, int receiver,
                                IsLit is_lit) {
    Look look;
    look.lights = {{.direction = light, .is_in_view_space = false, .shadow = Shadow::Hard}};
    renderer.load({.look = look, .primitives = std::make_shared<Primitives>(primitives)});
    renderer.draw(camera, size, size, {FrameImage::Shadow, FrameImage::Hit});
    const Image shadows = renderer.read(FrameImage::Shadow);
    const std::vector<SeenPrimitive> seen = cast_primitives(primitives, camera, size, size);
    ShadowCounts counts;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        if (seen[i].number != receiver || seen[i].normal.y() < 0.99) continue;
        const auto width = static_cast<std::size_t>(size);
        const Ray ray =
            camera_ray(camera, size, size, double(i % width) + 0.5, double(i / width) + 0.5);
        const Vec3d p_world = ray.origin_world + seen[i].t * ray.direction_world;
        const std::optional<bool> lit = is_lit(p_world);
        if (!lit) continue;
        EXPECT_EQ(shadows.rgba[4 * i], *lit ? 1 : 0) << p_world.transpose();
        ++(*lit ? counts.lit : counts.dark);
    }
    return counts;
}

} // namespace isocast::test
