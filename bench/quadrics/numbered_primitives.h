// Primitives that a picture tells apart by their colours, and scenes that are hard to draw: for the
// tests and the bench.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"
#include "raycaster/camera.h"

namespace isocast {

/// Colours that halves hold exactly, by number.
inline Vec3d colour_of_number(int number) {
    return {double(number & 1023), double(number >> 10 & 1023), double(number >> 20)};
}
/// -1 where nothing is drawn.
inline int number_of_colour(const float* rgba) {
    return rgba[3] == 0 ? -1
                        : static_cast<int>(rgba[0]) + 1024 * static_cast<int>(rgba[1]) +
                              1024 * 1024 * static_cast<int>(rgba[2]);
}

/// As splats_of() numbers them; sticks in one colour.
inline void number_by_colour(Primitives& primitives) {
    int number = 0;
    for_each_kind(primitives, [&](auto& some) {
        for (auto& one : some) one.colour = colour_of_number(number++);
    });
    for (Cylinder& stick : primitives.cylinders) stick.colour_b.reset();
    for_each_mesh(primitives, [&](auto& mesh) { mesh.colour = colour_of_number(number++); });
}

/// At z = 0, for a camera at (0, 0, 5) whose picture is 4 : 3.
inline Primitives spheres_at_borders_and_corners(const Camera& camera) {
    const double top = camera.half_height_at(5);
    Primitives primitives;
    for (const double y : {-1.0, 0.0, 1.0})
        for (const double x : {-4.0 / 3, 0.0, 4.0 / 3})
            primitives.spheres.push_back(
                {.centre_world = {x * top, y * top, 0}, .radius_world = 0.2 * top});
    return primitives;
}

} // namespace isocast
