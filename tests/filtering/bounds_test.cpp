// Certificates: no point of a block exceeds them, and they are no wider than their derivation says.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/random_fields.h"
#include "filtering/bounds.h"

#include "volume/grid_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace isocast {
namespace {

using test::Random;
using test::random_real;
constexpr std::array kernels{Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom};

/// Control samples of one block within rows and planes that are longer than the block needs, what
/// lies between being huge.
struct Block {
    int cells;
    std::ptrdiff_t stride_y, stride_z;
    std::vector<float> values;

    Block(int cells_, const std::function<double(int x, int y, int z)>& value)
        : cells(cells_), stride_y(cells + 3 + 5), stride_z(stride_y * (cells + 3 + 2)),
          values(static_cast<std::size_t>(stride_z * (cells + 3)), 1e20f) {
        for (int z = -1; z <= cells + 1; ++z) {
            for (int y = -1; y <= cells + 1; ++y) {
                for (int x = -1; x <= cells + 1; ++x) {
                    values[place(x, y, z)] = static_cast<float>(value(x, y, z));
                }
            }
        }
    }

    std::size_t place(int x, int y, int z) const {
        return static_cast<std::size_t>(x + 1 + (y + 1) * stride_y + (z + 1) * stride_z);
    }
    double at(int x, int y, int z) const { return values[place(x, y, z)]; }
    SplineBounds bounds(Kernel kernel) const {
        return spline_bounds(values.data(), stride_y, stride_z, cells, kernel);
    }
};

/// Value, first and second derivatives (as in SplineBounds) at a point of the closed block.
std::array<double, 10> evaluate(const Block& block, Kernel kernel, const Vec3d& p) {
    std::array<int, 3> cell{};
    std::array<std::array<std::array<double, 4>, 3>, 3> weights; // [axis][order]
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double x = p[static_cast<int>(axis)];
        cell[axis] = std::min(static_cast<int>(x), block.cells - 1);
        const double a = x - cell[axis];
        weights[axis] = {kernel_weights(kernel, a), kernel_weights_d1(kernel, a),
                         kernel_weights_d2(kernel, a)};
    }
    const auto sum = [&](std::size_t dx, std::size_t dy, std::size_t dz) {
        double total = 0;
        for (int k = 0; k < 4; ++k) {
            for (int j = 0; j < 4; ++j) {
                for (int i = 0; i < 4; ++i) {
                    total += weights[0][dx][static_cast<std::size_t>(i)] *
                             weights[1][dy][static_cast<std::size_t>(j)] *
                             weights[2][dz][static_cast<std::size_t>(k)] *
                             block.at(cell[0] + i - 1, cell[1] + j - 1, cell[2] + k - 1);
                }
            }
        }
        return total;
    };
    return {sum(0, 0, 0), sum(1, 0, 0), sum(0, 1, 0), sum(0, 0, 1), sum(2, 0, 0),
            sum(0, 2, 0), sum(0, 0, 2), sum(1, 1, 0), sum(1, 0, 1), sum(0, 1, 1)};
}

/// A point of the block; every third coordinate lies on a lattice plane, its faces included.
Vec3d random_point(Random& random, int cells) {
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) {
        p[axis] = random_real(random, 0, cells);
        if (random() % 3 == 0) p[axis] = std::round(p[axis]);
    }
    return p;
}

struct Kind {
    std::string name;
    std::function<double(int x, int y, int z)> value;
};

/// Smooth waves, noise, noise of all sizes on huge offsets, steep slopes, a distance with its kink,
/// spikes.
std::vector<Kind> kinds(Random& random) {
    std::vector<Kind> kinds;
    const Vec3d k(random_real(random, -0.5, 0.5), random_real(random, -0.5, 0.5), 0.3);
    kinds.push_back(
        {"smooth", [k](int x, int y, int z) { return std::sin(k.dot(Vec3d(x, y, z))); }});
    kinds.push_back({"noise", [&](int, int, int) { return random_real(random, -1, 1); }});
    for (const double offset : {1e3, -1e6, 1e8}) {
        for (const double size : {1e-3, 1.0, 100.0}) {
            kinds.push_back({"offset", [&random, offset, size](int x, int y, int z) {
                                 return offset + size * (x - 2 * y + 0.3 * z) +
                                        size * random_real(random, -1, 1);
                             }});
        }
    }
    // Nearly linear: first differences round by more than the second ones are.
    for (int i = 0; i < 10; ++i) {
        const Vec3d slope =
            random_real(random, 1, 1000) * Vec3d(1, random_real(random, -1, 1), 0.3);
        kinds.push_back({"steep", [slope](int x, int y, int z) {
                             return slope.dot(Vec3d(x - 3.3, y - 4.1, z - 4.6));
                         }});
    }
    kinds.push_back({"distance", [](int x, int y, int z) {
                         return std::hypot(x - 4.2, y - 3.7, z - 4.4) - 2.5;
                     }});
    kinds.push_back(
        {"spikes", [&random](int, int, int) { return random() % 50 == 0 ? 1.0 : -0.01; }});
    return kinds;
}

TEST(SplineBounds, HoldAtRandomPointsOfRandomBlocks) {
    Random random(1);
    for (const int cells : {8, 8, 8, 4, 5, 11}) {
        for (const Kind& kind : kinds(random)) {
            const Block block(cells, kind.value);
            for (const Kernel kernel : kernels) {
                const SplineBounds bounds = block.bounds(kernel);
                // The sums above: 64 terms below 8 times the magnitude (9a-5 and the like), each
                // rounded thrice, 3 * 64 * 8 * 1.1e-16 at most and a hundredth of that as a rule.
                const double rounding = 1e-14 * bounds.magnitude;
                for (int i = 0; i < 2000; ++i) {
                    const Vec3d p = random_point(random, cells);
                    const auto f = evaluate(block, kernel, p);
                    ASSERT_GE(f[0], bounds.min - rounding) << kind.name << p.transpose();
                    ASSERT_LE(f[0], bounds.max + rounding) << kind.name << p.transpose();
                    for (std::size_t d = 0; d < 3; ++d) {
                        ASSERT_LE(std::abs(f[1 + d]), bounds.slope[d] + rounding)
                            << kind.name << d << " at " << p.transpose();
                    }
                    for (std::size_t d = 0; d < 6; ++d) {
                        ASSERT_LE(std::abs(f[4 + d]), bounds.bend[d] + rounding)
                            << kind.name << d << " at " << p.transpose();
                    }
                }
            }
        }
    }
}

/// The greatest size of difference(x, y, z), computed in double, where all it reads lies in the
/// block: it reads as far as `reach`.
template<class Difference>
double greatest(const Block& block, const Index3& reach, Difference difference) {
    double most = 0;
    for (int z = -1; z + reach.z() <= block.cells + 1; ++z) {
        for (int y = -1; y + reach.y() <= block.cells + 1; ++y) {
            for (int x = -1; x + reach.x() <= block.cells + 1; ++x) {
                most = std::max(most, std::abs(difference(x, y, z)));
            }
        }
    }
    return most;
}

TEST(SplineBounds, AreTheBsplinesGreatestDifferencesRoundedOutward) {
    Random random(2);
    for (const int cells : {8, 4, 7, 13}) {
        for (const Kind& kind : kinds(random)) {
            const Block b(cells, kind.value);
            const SplineBounds bounds = b.bounds(Kernel::BSpline);
            float min = b.values[0];
            float max = min;
            for (int z = -1; z <= cells + 1; ++z) {
                for (int y = -1; y <= cells + 1; ++y) {
                    for (int x = -1; x <= cells + 1; ++x) {
                        min = std::min(min, b.values[b.place(x, y, z)]);
                        max = std::max(max, b.values[b.place(x, y, z)]);
                    }
                }
            }
            EXPECT_EQ(bounds.min, min);
            EXPECT_EQ(bounds.max, max);
            EXPECT_EQ(bounds.magnitude, std::max(std::abs(min), std::abs(max)));
            // Along axes a, b; differences of floats are exact in double, or err by 1e-16 of them.
            const auto first = [&](const Index3& s) {
                return greatest(b, s, [&](int x, int y, int z) {
                    return b.at(x + s.x(), y + s.y(), z + s.z()) - b.at(x, y, z);
                });
            };
            const auto second = [&](const Index3& s, const Index3& t) {
                const Index3 st = s + t;
                return greatest(b, st, [&](int x, int y, int z) {
                    return b.at(x + st.x(), y + st.y(), z + st.z()) -
                           b.at(x + s.x(), y + s.y(), z + s.z()) -
                           b.at(x + t.x(), y + t.y(), z + t.z()) + b.at(x, y, z);
                });
            };
            std::array<double, 3> slope{};
            for (int i = 0; i < 3; ++i) {
                const auto d = static_cast<std::size_t>(i);
                slope[d] = first(Index3::Unit(i));
                // 2^-24 for the computed difference, 2^-23 of slack, 2^-23 for the last rounding.
                EXPECT_GE(bounds.slope[d], slope[d]) << kind.name;
                EXPECT_LE(bounds.slope[d], slope[d] * (1 + 0x1p-21)) << kind.name;
            }
            constexpr std::array<std::array<int, 2>, 6> axes{
                {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
            for (std::size_t d = 0; d < 6; ++d) {
                const double bend = second(Index3::Unit(axes[d][0]), Index3::Unit(axes[d][1]));
                const double s = slope[static_cast<std::size_t>(axes[d][0])];
                // As above; and of the slope 2^-23 that was computed, 2^-23 of slack for it.
                EXPECT_GE(bounds.bend[d], bend) << kind.name;
                EXPECT_LE(bounds.bend[d], bend * (1 + 0x1p-21) + s * 0x1p-21) << kind.name;
            }
        }
    }
}

TEST(SplineBounds, AreExactForLinearFields) {
    // Sixteenths: every difference is exact in float.
    const Vec3d slope(0.75, -2.0, 1.0 / 16);
    const double offset = 3;
    const Block block(8, [&](int x, int y, int z) { return offset + slope.dot(Vec3d(x, y, z)); });
    for (const Kernel kernel : kernels) {
        const SplineBounds bounds = block.bounds(kernel);
        // The B-spline's hull has one sample more on each side.
        const double margin = kernel == Kernel::BSpline ? slope.cwiseAbs().sum() : 0;
        // 2^-22: first differences are rounded outward by 2^-23 and once more to float. Catmull-Rom
        // adds second differences that are zero but for 2^-23 of the slopes, 1.3 of them.
        const double rounding = kernel == Kernel::CatmullRom ? 0x1p-20 : 0x1p-22;
        EXPECT_NEAR(bounds.min, offset + 8 * slope.cwiseMin(0).sum() - margin, rounding);
        EXPECT_NEAR(bounds.max, offset + 8 * slope.cwiseMax(0).sum() + margin, rounding);
        for (std::size_t d = 0; d < 3; ++d) {
            EXPECT_NEAR(bounds.slope[d], std::abs(slope[static_cast<int>(d)]), 2 * rounding);
        }
        for (const float bend : bounds.bend) {
            if (is_smooth(kernel)) {
                EXPECT_LE(bend, 2.0 * 4.6875 * 0x1p-22);
            } else {
                EXPECT_EQ(bend, no_bend);
            }
        }
    }
}

TEST(SplineBounds, BendIsTheSecondDerivativeForQuadraticFields) {
    // Integers: differences are exact. xx yy zz xy xz yz of the second derivative:
    const std::array<double, 6> bend{6, 2, 4, 5, 3, 1};
    const Block block(8, [](int x, int y, int z) {
        return 3 * x * x - y * y + 2 * z * z + 5 * x * y - 3 * x * z + y * z;
    });
    const SplineBounds bspline = block.bounds(Kernel::BSpline);
    const SplineBounds catmull_rom = block.bounds(Kernel::CatmullRom);
    for (std::size_t d = 0; d < 6; ++d) {
        // Slopes reach 150: 2^-23 of that, and roundings of the bend itself.
        EXPECT_NEAR(bspline.bend[d], bend[d], 151 * 0x1p-22);
        // The constants that bounds.cpp derives: 3 (5/4)^2 and (3/2)^2 5/4.
        EXPECT_NEAR(catmull_rom.bend[d], (d < 3 ? 4.6875 : 2.8125) * bend[d],
                    4.6875 * 151 * 0x1p-22);
    }
}

TEST(SplineBounds, OfCatmullRomAreReachedByTheWorstSamplesAlongAnAxis) {
    // At a = 1/2 the weights are -1, 9, 9, -1 (/16): samples of those signs reach the Lebesgue
    // constant 5/4.
    const Block block(8, [](int x, int, int) { return x == 3 || x == 4 ? 1.0 : -1.0; });
    const Vec3d middle(3.5, 4, 4);
    EXPECT_EQ(evaluate(block, Kernel::CatmullRom, middle)[0], 1.25);
    const SplineBounds bounds = block.bounds(Kernel::CatmullRom);
    EXPECT_GE(bounds.max, 1.25f);
    // The corners' 1 and 1/8 of h_xx = 2, h_yy = h_zz = 0. Rounding: 2^-23 of slopes and bends
    // of 2.
    EXPECT_NEAR(bounds.max, 1.25, 0x1p-21);

    // To the last bit, where the bound is no float.
    Random random(3);
    for (int i = 0; i < 200; ++i) {
        const double size = random_real(random, 1, 2);
        const Block scaled(8, [&](int x, int, int) { return x == 3 || x == 4 ? size : -size; });
        EXPECT_GE(scaled.bounds(Kernel::CatmullRom).max,
                  evaluate(scaled, Kernel::CatmullRom, middle)[0]);
    }
}

TEST(SplineBounds, HoldSecondDifferencesThatFirstOnesRoundAway) {
    // 1 + e and 1 - e are 1 in float; the second difference -2 e is all the bend that there is.
    const double e = 0x1p-26;
    const Block block(8, [&](int x, int, int) { return x == 3 ? e : x - 3.0; });
    const SplineBounds bounds = block.bounds(Kernel::BSpline);
    EXPECT_GE(bounds.bend[0], 2 * e);
    EXPECT_LE(bounds.bend[0], 0x1p-22); // 2^-23 of slope 1
    EXPECT_GE(bounds.slope[0], 1 + e);
}

TEST(SplineBounds, NoBendMakesTheSecondOrderStepTheShorterOne) {
    // The step of FORMULAS.md for f > 0, in float as a shader computes it.
    for (const float f : {1e-6f, 1.0f, 1e6f}) {
        for (const float slope : {-1.0f, 0.0f, 1.0f}) {
            const float m = no_bend;
            const float root = std::sqrt(slope * slope + 2 * m * f);
            const float step = slope <= 0 ? 2 * f / (root - slope) : (slope + root) / m;
            EXPECT_FALSE(std::isnan(step));
            EXPECT_LT(step, f / 2); // f/L with L = 2
        }
    }
}

} // namespace
} // namespace isocast
