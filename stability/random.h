// Seeded random numbers and points.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <cmath>
#include <random>

namespace isocast::stability {

class Random {
public:
    explicit Random(unsigned seed) : bits_(seed) {}
    /// By hand: the standard does not say which numbers its distributions give.
    double uniform(double lo, double hi) {
        return lo + (hi - lo) * (static_cast<double>(bits_() >> 11) * 0x1p-53);
    }
    double log_uniform(double lo, double hi) {
        return std::exp(uniform(std::log(lo), std::log(hi)));
    }
    Vec3d in_cube(double half = 1) {
        const double x = uniform(-half, half), y = uniform(-half, half);
        return {x, y, uniform(-half, half)};
    }
    Vec3d unit() {
        for (;;) {
            const Vec3d p = in_cube();
            if (p.norm() < 1 && p.norm() > 0.1) return p.normalized();
        }
    }
    Mat3d rotation() { return Eigen::AngleAxisd(uniform(-3.14, 3.14), unit()).toRotationMatrix(); }

private:
    std::mt19937_64 bits_;
};

} // namespace isocast::stability
