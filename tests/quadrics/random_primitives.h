// Seeded primitives and rays for the tests of this folder.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"

#include <cmath>
#include <cstdint>
#include <random>

namespace isocast {

class Random {
public:
    explicit Random(std::uint64_t seed) : generator_(seed) {}
    double uniform(double lo, double hi) {
        return std::uniform_real_distribution<double>(lo, hi)(generator_);
    }
    double log_uniform(double lo, double hi) {
        return std::exp(uniform(std::log(lo), std::log(hi)));
    }
    bool coin() { return uniform(0, 1) < 0.5; }
    Vec3d in_cube(double half) {
        return {uniform(-half, half), uniform(-half, half), uniform(-half, half)};
    }
    Vec3d unit() {
        for (;;) {
            const Vec3d v = in_cube(1);
            if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
        }
    }
    Mat3d rotation() {
        const Vec3d x = unit();
        const Vec3d y = x.cross(unit()).normalized();
        Mat3d m;
        m << x, y, x.cross(y);
        return m;
    }

    Sphere sphere() { return {.centre_world = in_cube(1), .radius_world = log_uniform(0.01, 2)}; }
    Ellipsoid ellipsoid() {
        const Vec3d lengths(log_uniform(0.1, 1), log_uniform(0.1, 1), log_uniform(0.1, 1));
        return {.centre_world = in_cube(1),
                .axes_world = rotation() * lengths.asDiagonal() * rotation()};
    }
    Cylinder cylinder() {
        const Vec3d a = in_cube(1);
        return {.a_world = a,
                .b_world = a + unit() * log_uniform(0.1, 3),
                .radius_world = log_uniform(0.02, 1),
                .is_capped = coin()};
    }
    Cone cone() {
        const Vec3d a = in_cube(1);
        const double ra = uniform(0, 1) < 0.3 ? 0 : log_uniform(0.05, 1);
        const double rb = ra > 0 && uniform(0, 1) < 0.4 ? 0 : log_uniform(0.05, 1);
        return {.a_world = a,
                .b_world = a + unit() * log_uniform(0.1, 3),
                .radius_a_world = ra,
                .radius_b_world = rb,
                .is_capped = coin()};
    }
    /// Of every class: ellipsoids, hyperboloids of one and two sheets, paraboloids, saddles,
    /// parabolic and hyperbolic cylinders, planes.
    ClippedQuadric clipped_quadric() {
        const auto sign = [&] { return std::floor(uniform(-1, 2)); };
        const Mat3d r = rotation();
        ClippedQuadric k;
        k.centre_world = in_cube(1);
        k.axes_world =
            rotation() *
            Vec3d(log_uniform(0.2, 1), log_uniform(0.2, 1), log_uniform(0.2, 1)).asDiagonal();
        k.a = r * Vec3d(sign() * uniform(0.5, 2), sign() * uniform(0.5, 2), sign()).asDiagonal() *
              r.transpose();
        k.a = ((k.a + k.a.transpose()) / 2).eval();
        k.b = in_cube(0.5);
        k.c = uniform(-0.7, 0.3);
        return k;
    }

private:
    std::mt19937_64 generator_;
};

} // namespace isocast
