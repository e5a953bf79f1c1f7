// Seeded random solids: rough spheres, and unions of spheres and boxes as overlapping shells.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "stability/shapes.h"
#include <random>

namespace isocast::test {

using namespace stability; // its meshes

/// Two to five spheres, boxes and tetrahedra, turned at random and most of them overlapping.
inline Mesh overlapping_shells(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&] {
        const double x = unit(random);
        const double y = unit(random);
        return Vec3d(x, y, unit(random));
    };
    Mesh mesh;
    for (unsigned count = 2 + random() % 4; count > 0; --count) {
        const unsigned kind = random() % 3;
        const Mesh shape = kind == 0 ? sphere(2) : kind == 1 ? cube() : tetrahedron();
        const Vec3d axis = vector().normalized();
        const Mat3d turn = Eigen::AngleAxisd(3 * unit(random), axis).toRotationMatrix();
        const double size = 0.55 + 0.25 * unit(random);
        const Vec3d middle = 0.8 * vector();
        mesh = joined(
            mesh, mapped(shape, [&](const Vec3d& p) { return Vec3d(size * (turn * p) + middle); }));
    }
    return mesh;
}

} // namespace isocast::test
