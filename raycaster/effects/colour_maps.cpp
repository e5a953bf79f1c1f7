// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/colour_maps.h"

#include "raycaster/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace isocast {

namespace {

Vec3d viridis(double t) {
    // Every 15th of the 256 published.
    static constexpr std::array<std::array<double, 3>, 18> srgb{{
        {0.267004, 0.004874, 0.329415},
        {0.281924, 0.089666, 0.412415},
        {0.280255, 0.165693, 0.476498},
        {0.263663, 0.237631, 0.518762},
        {0.237441, 0.305202, 0.541921},
        {0.208623, 0.367752, 0.552675},
        {0.182256, 0.426184, 0.557120},
        {0.159194, 0.482237, 0.558073},
        {0.137770, 0.537492, 0.554906},
        {0.121148, 0.592739, 0.544641},
        {0.128087, 0.647749, 0.523491},
        {0.180653, 0.701402, 0.488189},
        {0.274149, 0.751988, 0.436601},
        {0.395174, 0.797475, 0.367757},
        {0.535621, 0.835785, 0.281908},
        {0.688944, 0.865448, 0.182725},
        {0.845561, 0.887322, 0.099702},
        {0.993248, 0.906157, 0.143936},
    }};
    const double place = t * (srgb.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(place), srgb.size() - 2);
    const double a = place - static_cast<double>(i);
    Vec3d colour;
    for (std::size_t c = 0; c < 3; ++c)
        colour[static_cast<int>(c)] = srgb_decoded((1 - a) * srgb[i][c] + a * srgb[i + 1][c]);
    return colour;
}

/// Polar coordinates of CIELAB [Moreland 2009]: length, angle from L, angle of (a, b).
struct Msh {
    double m;
    double s;
    double h;
};

Vec3d linear_from_msh(const Msh& c) {
    const double l = c.m * std::cos(c.s);
    const double a = c.m * std::sin(c.s) * std::cos(c.h);
    const double b = c.m * std::sin(c.s) * std::sin(c.h);
    const auto inverse = [](double t) { // CIE 15
        constexpr double knee = 6.0 / 29;
        return t > knee ? t * t * t : 3 * knee * knee * (t - 4.0 / 29);
    };
    const double y = (l + 16) / 116;
    const Vec3d d65(0.9505, 1, 1.089);
    const Vec3d xyz =
        d65.cwiseProduct(Vec3d(inverse(y + a / 500), inverse(y), inverse(y - b / 200)));
    Mat3d rgb_from_xyz;
    rgb_from_xyz << 3.2406, -1.5372, -0.4986, -0.9689, 1.8758, 0.0415, 0.0557, -0.2040, 1.0570;
    return (rgb_from_xyz * xyz).cwiseMax(0).cwiseMin(1);
}

Vec3d cool_warm(double t) {
    constexpr Msh cool{80, 1.08, -1.1};
    constexpr Msh warm{80, 1.08, 0.5};
    constexpr double white = 88;
    const Msh end = t < 0.5 ? cool : warm;
    // White has no hue; this one makes the way to it even.
    const double spin =
        end.s * std::sqrt(white * white - end.m * end.m) / (end.m * std::sin(end.s));
    const double white_hue = end.h > -std::numbers::pi / 3 ? end.h + spin : end.h - spin;
    const double a = std::abs(2 * t - 1); // of the end's colour
    return linear_from_msh(
        {white + a * (end.m - white), a * end.s, white_hue + a * (end.h - white_hue)});
}

} // namespace

Vec3d colour_of(ColourMap map, double t) {
    return map == ColourMap::Viridis ? viridis(t) : cool_warm(t);
}

} // namespace isocast
